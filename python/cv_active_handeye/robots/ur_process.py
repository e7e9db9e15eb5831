# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The caller's side of `ur_child`: requests that return within their deadline, or the process is given up."""

from __future__ import annotations

import json
import queue
import subprocess
import sys
import threading
from contextlib import suppress
from typing import Any

from .waiting import watched_waits

GRACE_S = 0.5  # for the process itself, beyond the deadline of the call inside it


class UrCallError(RuntimeError):
    """ur_rtde raised an error; missing: the name of a module that is not installed, or None."""

    def __init__(self, text: str, missing: str | None) -> None:
        """`text`: what ur_rtde said."""
        super().__init__(text)
        self.missing = missing


class UrProcessLostError(RuntimeError):
    """A call did not return within its deadline, or the process ended; it was given up."""


class UrProcess:
    """One process with ur_rtde in it, for one controller. One request at a time, from any thread."""

    def __init__(self, host: str) -> None:
        """Starts the process (0.5 s, of which the first request waits)."""
        command = [sys.executable, "-m", "cv_active_handeye.robots.ur_child", host]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            start_new_session=True,
        )
        self._lock = threading.Lock()
        self._answers: queue.Queue[dict[str, Any] | None] = queue.Queue()
        self._count = 0
        self._reader = threading.Thread(target=self._read, name="UR process", daemon=True)
        self._reader.start()

    @property
    def alive(self) -> bool:
        """Whether requests can be answered."""
        return self._process.poll() is None

    def ask(self, call: str, *arguments: object, deadline: float) -> Any:
        """The answer to a request; UrCallError or, `deadline` + 0.5 s after it was sent, UrProcessLostError.

        Waits for other threads' requests up to `deadline` before that. A pause of this process counts as no time.
        """
        if not any(self._lock.acquire(timeout=wait) for wait in watched_waits(deadline)):
            self.kill()
            raise UrProcessLostError(f"{call}: another call does not return")
        try:
            self._count += 1
            self._send({"id": self._count, "call": call, "arguments": arguments, "deadline": deadline})
            answer = self._answer(self._count, deadline + GRACE_S)
        finally:
            self._lock.release()
        if answer is None:
            self.kill()
            raise UrProcessLostError(f"{call}: no answer within {deadline:g} s")
        if "error" in answer:
            raise UrCallError(answer["error"], answer["missing"])
        return answer["value"]

    def finish(self, deadline: float) -> None:
        """Lets the process end by itself within `deadline` s, which stops and restores what is left, or kills it."""
        if self._process.stdin is not None:
            with suppress(OSError):  # it may have ended already
                self._process.stdin.close()
        try:
            self._process.wait(deadline)
        except subprocess.TimeoutExpired:
            self.kill()
        self._reader.join(1.0)
        if self._process.stdout is not None:
            self._process.stdout.close()

    def kill(self) -> None:
        """Gives the process up; the controller sees its connections close."""
        self._process.kill()
        self._process.wait(5.0)

    def _send(self, request: dict[str, Any]) -> None:
        stdin = self._process.stdin
        try:
            if stdin is None or stdin.closed:
                raise UrProcessLostError(f"{request['call']}: the connection is closed")
            stdin.write(json.dumps(request) + "\n")
            stdin.flush()
        except OSError as error:
            raise UrProcessLostError(f"{request['call']}: the process for ur_rtde has ended") from error

    def _answer(self, number: int, seconds: float) -> dict[str, Any] | None:
        """The answer with this number, None when none came; older ones belong to calls that were interrupted."""
        for wait in watched_waits(seconds):
            with suppress(queue.Empty):
                answer = self._answers.get(timeout=wait)
                if answer is None or answer["id"] == number:
                    return answer
        return None

    def _read(self) -> None:
        if self._process.stdout is not None:
            for line in self._process.stdout:
                self._answers.put(json.loads(line))
        self._answers.put(None)


def told(host: str, upper_registers: bool, error: UrCallError | UrProcessLostError) -> str:
    """What hindered ur_rtde from connecting to `host`, for a person."""
    text = str(error)
    if isinstance(error, UrCallError) and error.missing is not None:
        return f"ur_rtde is not installed ({error.missing}): pip install 'cv_active_handeye[ur]'"
    if "in use" in text.lower() or "IN_USE" in text or "fieldbus" in text.lower():
        cure = "disable it, or set upper_registers" if not upper_registers else "disable it"
        return (
            f"{host}: the RTDE registers belong to a fieldbus (EtherNet/IP, PROFINET, MODBUS) or to another "
            f"client: {cure} ({text})"
        )
    return f"{host}: ur_rtde cannot use the controller: {text}"
