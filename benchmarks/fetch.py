# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Throughput of `tumtools fetch` from loopback against `curl -o`, and its memory.

usage: python benchmarks/fetch.py [MEGABYTES]

Each is run several times in turns, as a program, on a memory file system; the best of each counts. The files
do not compress; no checksum is known.
"""

from __future__ import annotations

import contextlib
import http.server
import json
import os
import shutil
import socketserver
import subprocess
import sys
import tarfile
import tempfile
import time
import zlib
from pathlib import Path

ROUNDS = 3
MEMBER_MEGABYTES = 8


class _Sender(http.server.BaseHTTPRequestHandler):
    """Sends files with sendfile, so that the server costs little."""

    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        path = Path(self.path)
        self.send_response(200)
        self.send_header("Content-Length", str(path.stat().st_size))
        self.send_header("ETag", '"one"')
        self.end_headers()
        self.wfile.flush()
        with path.open("rb") as file, contextlib.suppress(OSError):
            self.connection.sendfile(file)

    def log_message(self, *_: object) -> None:
        pass


def serve() -> None:
    """Serve the whole file system on loopback and print the port; run as a program of its own."""
    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), _Sender) as server:
        server.daemon_threads = True
        print(server.server_address[1], flush=True)
        server.serve_forever()


def make_files(folder: Path, megabytes: int) -> dict[str, Path]:
    block = os.urandom(1 << 20)
    bag, tgz = folder / "big.bag", folder / "big.tgz"
    with bag.open("wb") as file:
        file.write(b"#ROSBAG V2.0\n")
        for _ in range(megabytes):
            file.write(block)
    compress = zlib.compressobj(1, wbits=31)
    with tgz.open("wb") as file:
        for number in range(megabytes // MEMBER_MEGABYTES):
            member = tarfile.TarInfo(f"big/{number}.bin")
            member.size = MEMBER_MEGABYTES << 20
            file.write(compress.compress(member.tobuf()))
            for _ in range(MEMBER_MEGABYTES):
                file.write(compress.compress(block))
        file.write(compress.compress(bytes(1024)) + compress.flush())
    return {"bag": bag, "tgz": tgz}


def run(command: list[str], environment: dict[str, str]) -> tuple[float, float]:
    """Run a program; return seconds and its peak memory in megabytes."""
    begin = time.perf_counter()
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - begin
    if status:
        sys.exit(f"failed: {' '.join(command)}")
    return seconds, usage.ru_maxrss / 1024


def main(megabytes: int) -> None:
    shared = Path("/dev/shm")  # noqa: S108 - a memory file system
    server = subprocess.Popen([sys.executable, __file__, "--serve"], stdout=subprocess.PIPE, text=True)
    port = server.stdout.readline().strip() if server.stdout else ""
    with tempfile.TemporaryDirectory(dir=shared if shared.is_dir() else None) as name:
        folder = Path(name)
        files = make_files(folder, megabytes)
        urls = {kind: f"http://127.0.0.1:{port}{path}" for kind, path in files.items()}
        entries = [{"name": f"big_{kind}", "files": {kind: {"urls": [url]}}} for kind, url in urls.items()]
        (folder / "catalogue.json").write_text(json.dumps({"sequences": entries}))
        environment = {
            **os.environ,
            "TUMTOOLS_CACHE": str(folder / "cache"),
            "TUMTOOLS_CATALOGUE": str(folder / "catalogue.json"),
            "TUMTOOLS_LOCK": str(folder / "lock"),
            "no_proxy": "127.0.0.1",
        }
        ours = [sys.executable, "-m", "tumtools", "-q", "fetch"]
        commands = {
            "curl -o": ["curl", "-s", "-o", str(folder / "out"), urls["bag"]],
            "fetch of a recording": [*ours, "big_bag"],
            "fetch --no-extract of an archive": [*ours, "--no-extract", "big_tgz"],
            "fetch of an archive, unpacked": [*ours, "big_tgz"],
        }
        best: dict[str, tuple[float, float]] = {}
        for _ in range(ROUNDS):
            for title, command in commands.items():
                shutil.rmtree(folder / "cache", ignore_errors=True)
                (folder / "lock").unlink(missing_ok=True)
                (folder / "out").unlink(missing_ok=True)
                best[title] = min(best.get(title, (1e9, 0.0)), run(command, environment))
        for title, (seconds, memory) in best.items():
            ratio = best["curl -o"][0] / seconds
            print(
                f"{title:34} {megabytes / seconds:7.0f} MB/s  {ratio:5.2f} x curl  {memory:6.0f} MB at most"
            )
    server.terminate()
    server.wait()


if __name__ == "__main__":
    if sys.argv[1:] == ["--serve"]:
        serve()
    else:
        main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
