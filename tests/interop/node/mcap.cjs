// SPDX-FileCopyrightText: 2026 The tumtools authors
// SPDX-License-Identifier: MIT
"use strict";
// MCAP of profile ros1 or ros2 with @mcap/core, decoded with the embedded definitions: node mcap.cjs FILE...
const { open } = require("node:fs/promises");
const { load, main } = require("./common.cjs");
const { McapIndexedReader } = load("@mcap/core");
const { FileHandleReadable } = load("@mcap/nodejs");
const { loadDecompressHandlers } = load("@mcap/support");
const { parse } = load("@foxglove/rosmsg");
const ros1 = load("@foxglove/rosmsg-serialization");
const ros2 = load("@foxglove/rosmsg2-serialization");

main(async (file, emit) => {
  const handle = await open(file, "r");
  const reader = await McapIndexedReader.Initialize({
    readable: new FileHandleReadable(handle),
    decompressHandlers: await loadDecompressHandlers(),
  });
  const decoders = new Map();
  for await (const { channelId, logTime, publishTime, data } of reader.readMessages()) {
    const channel = reader.channelsById.get(channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    if (!decoders.has(channelId)) {
      const definition = parse(new TextDecoder().decode(schema.data), { ros2: schema.encoding === "ros2msg" });
      const { MessageReader } = schema.encoding === "ros2msg" ? ros2 : ros1;
      decoders.set(channelId, new MessageReader(definition));
    }
    const message = decoders.get(channelId).readMessage(data);
    emit({ topic: channel.topic, type: schema.name, time: logTime, publish_time: publishTime, message });
  }
  await handle.close();
});
