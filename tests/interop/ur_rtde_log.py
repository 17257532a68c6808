#!/usr/bin/env python3
"""Logs a UR controller with the package ur-rtde.

    ur_rtde_log.py HOST SECONDS OUT.csv

The controller must listen on HOST:30004, the only port that ur-rtde knows. Ends with 1 if the controller closes the connection earlier.
"""
import sys
import time

import rtde_receive


def main():
    if len(sys.argv) != 4:
        sys.exit("usage: ur_rtde_log.py HOST SECONDS OUT.csv")
    host, seconds, out = sys.argv[1], float(sys.argv[2]), sys.argv[3]
    receiver = rtde_receive.RTDEReceiveInterface(host)
    if not receiver.startFileRecording(out):
        sys.exit(f"ur_rtde_log.py: {out}: the recording did not start")
    end = time.monotonic() + seconds
    while time.monotonic() < end and receiver.isConnected():
        time.sleep(0.01)
    connected = receiver.isConnected()
    receiver.stopFileRecording()
    print("newest:", receiver.getTimestamp(), receiver.getActualTCPPose(), receiver.getActualDigitalOutputBits())
    receiver.disconnect()
    if not connected:
        sys.exit("ur_rtde_log.py: the controller closed the connection")


if __name__ == "__main__":
    main()
