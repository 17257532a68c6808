"""The row about robot logs: tactile and ur-rtde log the same controller at the same time."""

import socket
import sys

from compare_robot_logs import differences
from programs import FAKE_CONTROLLER, RECORDINGS, ROOT, TACTILE, Process
from table import Difference, Skipped, row

PORT = 30004  # ur-rtde knows no other port


@row("log of a controller by record and by ur-rtde", "rtde_receive")
def robot_log(folder):
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", PORT))
        except OSError as error:
            raise Skipped(f"ur-rtde needs port {PORT}, which is in use: {error}")
    theirs = folder / "theirs.csv"
    with Process(FAKE_CONTROLLER, "--port", PORT, "--seconds", "30") as controller:
        controller.wait_for(str(PORT))
        with Process(sys.executable, ROOT / "tests" / "interop" / "ur_rtde_log.py", "127.0.0.1", "6", theirs) as log:
            with Process(TACTILE, "record", "--from", f"file:{RECORDINGS / 'dv-lz4.aedat4'}", "--speed", "0.003", "--robot",
                         f"127.0.0.1:{PORT}", "--out", folder / "runs", "--object", "fan", "--run", "01", "--duration", "5") as record:
                record.wait()
            log.wait()
    if found := differences(folder / "runs" / "fan" / "01" / "robot.csv", theirs):
        raise Difference(f"{len(found)} values differ, first: {found[0]}")
