"""The command `metrolux`: where it is, and a rendering as a process of its own."""

import json
import os
import queue
import shutil
import signal
import subprocess
import threading

PATIENCE = 20  # seconds for the pass in progress and the image after a cancel


class NotFound(Exception):
    """There is no command; the text says where it was looked for."""


def find(preferred=""):
    """The path of the command: of the preferences, METROLUX_COMMAND, or the search path."""
    for candidate in (preferred, os.environ.get("METROLUX_COMMAND", "")):
        if candidate:
            if os.access(candidate, os.X_OK) and os.path.isfile(candidate):
                return candidate
            raise NotFound(f"{candidate} is no program; set the command of Metrolux in the preferences of the add-on")
    found = shutil.which("metrolux")
    if not found:
        raise NotFound("found no command `metrolux` on the search path; set it in the preferences of the add-on")
    return found


class Rendering:
    """A running `metrolux render`. Its events arrive in `events()`; see docs/reference/command.md, Progress for programs."""

    def __init__(self, command, scene, image, arguments):
        words = [command, "render", scene, "-o", image, "--overwrite", "--progress", "json", *arguments]
        # A group of its own: Ctrl-C in the terminal is for Blender, which passes it on.
        self._process = subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
        )
        self._events, self._last_words = queue.Queue(), []
        self._threads = [threading.Thread(target=self._read_events, daemon=True),
                         threading.Thread(target=self._read_words, daemon=True)]
        for thread in self._threads:
            thread.start()

    def _read_events(self):
        for line in self._process.stdout:
            try:
                self._events.put(json.loads(line))
            except ValueError:
                pass  # a line of a version that writes other things, too

    def _read_words(self):
        for line in self._process.stderr:
            self._last_words = self._last_words[-20:] + [line.decode(errors="replace").rstrip()]

    def events(self, timeout):
        """The events since the last call; waits up to `timeout` seconds for one."""
        result = []
        try:
            result.append(self._events.get(timeout=timeout))
            while True:
                result.append(self._events.get_nowait())
        except queue.Empty:
            return result

    @property
    def is_running(self):
        return self._process.poll() is None or any(thread.is_alive() for thread in self._threads)

    @property
    def status(self):
        return self._process.returncode

    @property
    def last_words(self):
        return "\n".join(self._last_words)

    def stop(self):
        """Ends the pass in progress; the command writes the image."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)

    def end(self):
        """Waits for the command, and kills it if it takes too long."""
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for thread in self._threads:
            thread.join(1)
        self._process.stdout.close()
        self._process.stderr.close()
