#!/usr/bin/env python3
"""ur_rtde_log.py HOST SECONDS OUT.csv: logs a UR controller with the ur-rtde package, as its users do.

ur-rtde takes no port: the controller listens on HOST:30004. Prints the rows' count.
"""
import sys
import time

import rtde_receive

FIELDS = ["timestamp", "target_q", "actual_q", "actual_qd", "actual_TCP_pose", "actual_TCP_speed", "actual_TCP_force",
          "actual_digital_output_bits", "runtime_state", "robot_mode", "output_int_register_2"]


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
