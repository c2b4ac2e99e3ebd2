// SPDX-FileCopyrightText: 2026 The tumtools authors
// SPDX-License-Identifier: MIT
"use strict";
// sqlite3 files of rosbag2 with @foxglove/rosbag2-web: node rosbag2_sqlite3.cjs FILE...
const fs = require("node:fs");
const { load, main, nanoseconds } = require("./common.cjs");
const { Rosbag2 } = load("@foxglove/rosbag2");
const { SqliteSqljs } = load("@foxglove/rosbag2-web");

main(async (file, emit) => {
  await SqliteSqljs.Initialize({
    wasmBinary: fs.readFileSync(load.resolve("@foxglove/sql.js/dist/sql-wasm.wasm")),
  });
  const bag = new Rosbag2([new SqliteSqljs(new Uint8Array(fs.readFileSync(file)))]);
  await bag.open();
  for await (const { topic, timestamp, value } of bag.readMessages({ topics: undefined })) {
    emit({ topic: topic.name, type: topic.type, time: nanoseconds(timestamp), message: value });
  }
});
