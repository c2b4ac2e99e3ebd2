// SPDX-FileCopyrightText: 2026 The tumtools authors
// SPDX-License-Identifier: MIT
"use strict";
// Shared by the readers: where the packages are, and how a decoded message is printed.
const { createHash } = require("node:crypto");
const { createRequire } = require("node:module");
const path = require("node:path");

const modules = process.env.TUMTOOLS_NODE_MODULES ?? path.join(__dirname, "node_modules");
exports.load = createRequire(path.join(modules, "_"));

// Nanoseconds of {sec, nsec}, as text: they do not fit a JavaScript number.
exports.nanoseconds = (time) => (BigInt(time.sec) * 1000000000n + BigInt(time.nsec)).toString();

// Long byte arrays become their SHA-256, times become text, everything else plain JSON.
exports.plain = (value) => {
  if (typeof value === "bigint") return value.toString();
  if (value === null || typeof value !== "object") return value;
  if (value instanceof Uint8Array) {
    return { length: value.length, sha256: createHash("sha256").update(value).digest("hex") };
  }
  if (ArrayBuffer.isView(value)) return Array.from(value, exports.plain);
  if (Array.isArray(value)) return value.map(exports.plain);
  if ("sec" in value && ("nsec" in value || "nanosec" in value)) {
    return exports.nanoseconds({ sec: value.sec, nsec: value.nsec ?? value.nanosec });
  }
  return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, exports.plain(item)]));
};

// Run `read(file, emit)` for each file of the command line; one JSON line per message goes to stdout.
exports.main = async (read) => {
  for (const file of process.argv.slice(2)) {
    const lines = [];
    await read(file, (message) => lines.push(JSON.stringify(exports.plain(message)) + "\n"));
    process.stdout.write(lines.join(""));
  }
};
