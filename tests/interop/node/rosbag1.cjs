// SPDX-FileCopyrightText: 2026 The tumtools authors
// SPDX-License-Identifier: MIT
"use strict";
// ROS 1 bags with @foxglove/rosbag: node rosbag1.cjs FILE...
const { load, main, nanoseconds } = require("./common.cjs");
const { Bag } = load("@foxglove/rosbag");
const { FileReader } = load("@foxglove/rosbag/node");
const Bzip2 = load("@foxglove/wasm-bz2");
const lz4 = load("@foxglove/wasm-lz4");

main(async (file, emit) => {
  const lz4Module = lz4.default ?? lz4;
  await lz4Module.isLoaded;
  const bzip2 = await (Bzip2.default ?? Bzip2).init();
  const bag = new Bag(new FileReader(file), {
    decompress: {
      lz4: (bytes, size) => lz4Module(bytes, size),
      bz2: (bytes, size) => bzip2.decompress(bytes, size, { small: false }),
    },
  });
  await bag.open();
  for await (const { topic, timestamp, connectionId, message } of bag.messageIterator()) {
    const { type, md5sum } = bag.connections.get(connectionId);
    emit({ topic, type, md5sum, time: nanoseconds(timestamp), message });
  }
});
