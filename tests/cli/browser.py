"""Pages in a headless Chromium: serves folders, runs a page until it tells that it is done, and keeps what it drew.

A page ends with `await tell(result, picture)`: any JSON, and a canvas or nothing. CesiumJS and MapLibre GL JS come from the node_modules in
the folder that FURROW_CLIENTS names: `npm install cesium maplibre-gl`.
"""
import base64
import functools
import http.server
import json
import os
import pathlib
import shutil
import subprocess
import threading
import unittest

CLIENTS = pathlib.Path(os.environ.get("FURROW_CLIENTS", "/nonexistent")) / "node_modules"
TELL = """<script>
async function tell(result, picture) {
  await fetch("/told", {method: "POST", body: JSON.stringify({result, picture: picture ? picture.toDataURL("image/png") : null})});
}
addEventListener("error", event => tell({error: String(event.message)}));
addEventListener("unhandledrejection", event => tell({error: String(event.reason && event.reason.stack || event.reason)}));
</script>
"""


def program():
    """The path of Chromium; without one the test skips."""
    found = shutil.which("chromium") or shutil.which("chromium-browser")
    if found is None:
        raise unittest.SkipTest("not on this machine: no chromium")
    return found


def client(name):
    """Skips the test where a client's package is not there."""
    if not (CLIENTS / name).is_dir():
        raise unittest.SkipTest(f"not on this machine: no {name} (npm install {name}, and FURROW_CLIENTS with its folder)")


class Handler(http.server.SimpleHTTPRequestHandler):
    def translate_path(self, path):
        path = path.split("?")[0]
        if path.startswith("/client/"):
            return str(CLIENTS / path[len("/client/"):])
        return super().translate_path(path)

    def do_GET(self):
        page = self.server.pages.get(self.path.split("?")[0])
        if page is None:
            return super().do_GET()
        self.send_response(200)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.end_headers()
        return self.wfile.write(page.encode())

    def do_POST(self):
        self.server.told = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.send_response(204)
        self.end_headers()
        self.server.done.set()

    def end_headers(self):
        for name, value in self.server.headers:
            self.send_header(name, value)
        super().end_headers()

    def log_message(self, text, *arguments):
        line = text % arguments
        if "/client/" not in line and "/told" not in line:
            self.server.asked.append(line)


class Server:
    """Serves a folder. `asked` has a line for each request, with its status."""

    def __init__(self, folder, headers=()):
        self.http = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=str(folder)))
        self.http.pages, self.http.asked, self.http.headers = {}, [], headers
        self.http.done, self.http.told = threading.Event(), None
        self.folder, self.address = folder, f"http://127.0.0.1:{self.http.server_port}"
        threading.Thread(target=self.http.serve_forever, daemon=True).start()

    @property
    def asked(self):
        return self.http.asked

    def close(self):
        self.http.shutdown()
        self.http.server_close()

    def missing(self):
        return [line for line in self.asked if " 404 " in line]

    def run(self, page, profile, size=(900, 700), seconds=150, picture=None, path="/test.html", touch=False):
        """Opens a page, HTML text, and returns what it told. `picture`: a path for the canvas that it told."""
        self.http.pages[path] = page.replace("<head>", "<head>" + TELL, 1)
        self.http.done.clear()
        command = [program(), "--headless=new", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                   "--ignore-gpu-blocklist", f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}", "--remote-debugging-port=0",
                   *(["--touch-events=enabled"] if touch else []), self.address + path]
        with open(os.devnull, "wb") as nowhere:
            running = subprocess.Popen(command, stdout=nowhere, stderr=nowhere)
        try:
            if not self.http.done.wait(seconds):
                raise AssertionError(f"the page told nothing in {seconds} s; it asked for {self.asked[-5:]}")
        finally:
            running.terminate()
            running.wait(30)
        told = self.http.told
        if told["picture"] is not None and picture is not None:
            pathlib.Path(picture).write_bytes(base64.b64decode(told["picture"].split(",")[1]))
        if isinstance(told["result"], dict) and "error" in told["result"]:
            raise AssertionError(told["result"]["error"])
        return told["result"]
