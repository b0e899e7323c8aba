"""The validation's checks: what each shows, and which tests print its lines. The one place that joins them."""

import collections

# `tests` are names of ctest; `claim` is one sentence for docs/validation.md. Tests print the figures of their check; where
# `counted`, what they show is not a figure, and the number of them that passed stands for it.
Check = collections.namedtuple("Check", "name claim tests counted", defaults=(False,))


def gtest(name):
    return f"_ctest_sinew_gtest_{name}"


def rostest(name):
    return f"_ctest_sinew_rostest_test_nodes_{name}.test"


# Scenes with contact: each states what holds in all of them.
CONTACT_SCENES = ("beam", "finger_obstacle", "gripper", "penetration", "tentacle", "trunk_rail")
DEADLINES = [rostest("deadlines")] + [f"_ctest_sinew_rostest_deadlines__rate_{rate}.test" for rate in (500, 1000)]
DECODERS = (
    "canopen_drive",
    "canopen_messages",
    "canopen_sdo",
    "cobs",
    "dynamixel_packet",
    "odrive_messages",
    "pressure_message",
    "simulated_cia402_drive",
    "sinew_board",
    "sinew_board_codec",
    "slcan_codec",
)
CAN_GUEST = "can_guest"  # no test of ctest, as the benchmark is none
TIMED_SCENES = gtest("benchmark_robot_scene_test")

CHECKS = (
    Check(
        "patch_test",
        "A body under a linear displacement field has the stress of that field everywhere, small or large, turned or not.",
        [gtest("fem_patch_test")],
    ),
    Check("rigid_motion", "Moving a body rigidly gives no elastic force.", [gtest("fem_patch_test")]),
    Check(
        "cantilever",
        "A cantilever under its own weight, ten times as long as high, against Timoshenko's beam: the value extrapolated "
        "with order 2 from 6 and 12 cells, the raw one at 12 cells, and the observed order.",
        [gtest("fem_cantilever_test")],
    ),
    Check(
        "elastica",
        "A slender cantilever with a load at its tip that bends it far, against the exact elastica.",
        [gtest("fem_elastica_test")],
    ),
    Check(
        "round_trip_accordion",
        "Three cables of an accordion are pulled, and the inverse of the reached point gives the pulls back.",
        [gtest("inverse_round_trip_test")],
    ),
    Check(
        "round_trip_trunk",
        "Eight cables of the trunk are pulled, and the inverse reaches the same points within the limits and with no more "
        "energy; with three points each at tip and middle it finds the same pulls.",
        [gtest("inverse_round_trip_test")],
    ),
    Check(
        "settling",
        "With a target that stays, the controller's one linearisation a cycle ends in equilibrium.",
        [gtest("inverse_settling_test")],
    ),
    Check(
        "period_independence",
        "50, 100 and 200 Hz, static and dynamic, settle to the same answer.",
        [gtest("inverse_settling_test")],
    ),
    Check(
        "qp_oracle",
        "Random programmes, degenerate and infeasible ones too, against an exact solver, and larger ones against optimality "
        "conditions and infeasibility certificates recomputed in the test.",
        [gtest("solver_qp_oracle_test")],
    ),
    Check(
        "out_of_reach",
        "Targets that no cable can bring the tip to: the commands come to rest within every limit.",
        [gtest("inverse_reach_test")],
    ),
    Check(
        "detection_oracle",
        "Contacts found through trees and cones against brute force with the same definition, and what enforcing them leaves "
        "of the depth of a surface after a step.",
        [gtest(f"contact_{noun}_test") for noun in ("surface_pairs", "smooth_pairs", "proximity_detection")],
    ),
    Check(
        "volume_contacts",
        "Overlap volumes from layered depths against exact ones, and their gradients.",
        [gtest("contact_volume_detection_test")],
    ),
    Check(
        "qpcc_oracle",
        "Random programmes with complementarity constraints, dependent and infeasible ones too, and those of live robots "
        "with other goals and limits, against the full formulation and the enumeration of all their pieces.",
        [gtest("solver_qpcc_oracle_test"), gtest("inverse_qpcc_oracle_test")],
    ),
    Check(
        "finger_obstacle",
        "Two cables pull the finger around a post, and the inverse of the reached point gives the pulls back.",
        [gtest("inverse_finger_obstacle_test")],
    ),
    Check(
        "signorini",
        "At the solution of every cycle's linear problem no contact is passed, none pulls, and none presses from afar.",
        [gtest(f"inverse_{scene}_test") for scene in CONTACT_SCENES] + [TIMED_SCENES],
    ),
    Check(
        "penetration",
        "How deep the real surface of a robot, sampled over every triangle, is in obstacles or in itself, with obstacles "
        "that move at 0.1 m/s and 100 cycles a second.",
        [gtest(f"inverse_{scene}_test") for scene in CONTACT_SCENES] + [TIMED_SCENES],
    ),
    Check(
        "contact_stability",
        "Robots that lean on something and are not moved: changes of the pairs that press, over 1000 cycles.",
        [gtest("inverse_contact_stability_test")],
    ),
    Check(
        "contact_soak",
        "Targets and obstacles move, appear and vanish at random for two minutes of the robots' time (30 with "
        "scripts/test --full): every cycle has an answer within what the devices allow, and every tension that gave way is "
        "reported.",
        [gtest("inverse_contact_soak_test")],
    ),
    Check(
        "crossing_cylinder",
        "The trunk's tip follows circles of 30 and 60 mm radius while a cylinder crosses its way.",
        [gtest("inverse_crossing_cylinder_test")],
    ),
    Check(
        "gripper",
        "Three fingers close on a ball, open, and follow it when it moves; without it they meet each other. Unequal pulls "
        "come back from the fingertips that they lead to.",
        [gtest("inverse_gripper_test")],
    ),
    Check(
        "tentacle",
        "One cable curls the tentacle until its ribs press against each other, and the inverse of the reached tip gives it "
        "back.",
        [gtest("inverse_tentacle_test")],
    ),
    Check(
        "beam",
        "A beam sways from the obstacle above it to the one below, and the inverse of either end gives both cables back.",
        [gtest("inverse_beam_test")],
    ),
    Check(
        "moving_obstacle",
        "The trunk keeps its tip where it is while a cylinder is pushed against it, drawn back, comes and goes.",
        [gtest("inverse_moving_obstacle_test")],
    ),
    Check(
        "trunk_rail",
        "The trunk on its rail is brought through between two cylinders, with either method of detection.",
        [gtest("inverse_trunk_rail_test")],
    ),
    Check(
        "no_allocation",
        "Over a controller's cycles with contacts that come and go nothing allocates memory.",
        [gtest("inverse_no_allocation_test")],
    ),
    Check(
        "overload",
        "Cycles that share a linearisation for want of time: how far the effector is from where whole cycles have it; and "
        "far above the rate that is possible every command still goes out.",
        [gtest("inverse_overload_test"), rostest("overload")],
    ),
    Check(
        "control_cycle",
        "The cycle thread of the running node takes no memory and no lock, at leisure and overloaded.",
        [rostest("control_cycle")],
    ),
    Check(
        "deadlines",
        "The whole line at 100, 500 and 1000 Hz while a cylinder comes and goes: commands that came late or not at all, beside "
        "those that a bare sleeping loop of the same priority would have missed in the same run.",
        DEADLINES,
    ),
    Check(
        "bad_input",
        "Targets that are not finite, jump, are late, or name what is not there are refused by name, and the next good one "
        "counts.",
        [rostest("bad_input")],
    ),
    Check(
        "trunk_circle",
        "The whole line follows a circle of 40 mm radius at 100 Hz, watched on the wire only; periods are compared with a "
        "bare sleeping loop of the same priority in the same run.",
        [rostest("trunk_circle")],
    ),
    Check(
        "moving_cylinder",
        "The whole line keeps the trunk's tip at its target while a cylinder, seen by a late and noisy tracker, pushes it.",
        [rostest("moving_cylinder")],
    ),
    Check(
        "trunk_rail_line",
        "The whole line brings the trunk on its rail through between two cylinders.",
        [rostest("trunk_rail")],
    ),
    Check(
        "restart_mid_motion",
        "The controller is killed and started again in the middle of the circle: no command steps, and the tip stays.",
        [rostest("restart_mid_motion")],
    ),
    Check(
        "servo_bus_faults",
        "Packets on the servo bus are corrupted, dropped and delayed: no wrong value is believed, and the counters agree "
        "with what was injected.",
        [gtest("hardware_dynamixel_bus_test"), gtest("hardware_hardware_driver_test")],
    ),
    Check(
        "command_loss",
        "Without a controller the driver holds, then relaxes, in the set times, and says why.",
        [gtest("hardware_hardware_driver_test"), rostest("command_loss")],
    ),
    Check(
        "command_authority",
        "A paused clock, a replayed recording, a second publisher and a host clock that is off move nothing.",
        [rostest("command_authority")],
    ),
    Check(
        "safety_states",
        "The driver's states: every pair of state and event leads where it should, any fault makes any state safe, and "
        "nothing but a person leads out of safety, whatever the order of events.",
        [gtest("hardware_driver_state_test")],
    ),
    Check(
        "fault_matrix",
        "Every simulated device with every fault, ready (idle), moving and under load: how long until the driver is in the "
        "state that the fault leads to, until every device that can has let go, and how far anything moves on recover.",
        [gtest("hardware_fault_matrix_test")],
    ),
    Check(
        "fuzz_corpus",
        "Inputs that a fuzzer has kept for each decoder, replayed, with thousands of small changes to them.",
        [gtest(f"fuzz_{decoder}_test") for decoder in DECODERS],
    ),
    Check(
        "protocol_vectors",
        "Byte-exact examples from public documents, named in the tests, for every protocol; those of the pressure boards from "
        "their document, for the driver's and the firmware's codec alike.",
        [
            gtest(f"hardware_{noun}_test")
            for noun in ("dynamixel_packet", "canopen_messages", "odrive_messages", "slcan_codec", "pressure_message")
        ]
        + [gtest("firmware_sinew_board_codec_test")],
        True,
    ),
    Check(
        "can_qemu",
        "CAN on a kernel's own bus, in a guest that scripts/can_guest boots: interfaces that go down and up, the kernel's own "
        "SLCAN driver, drives and ODrives over vcan. None is skipped.",
        [CAN_GUEST],
    ),
    Check(
        "driver_services",
        "A driver that is homing for half a minute is halted, stopped by service and topic, and shut down meanwhile.",
        [rostest("driver_services")],
    ),
    Check(
        "bus_load",
        "Twelve servos and four pressure channels at 200 Hz on simulated buses: how regular the driver is beside a bare "
        "sleeping loop in the same run, what it takes of a core, and every command and answer accounted for.",
        [rostest("bus_load")],
    ),
    Check(
        "kill_node",
        "Nodes are killed at random moments while the trunk moves: how long until the simulated devices are safe, after "
        "which the robot comes back with recover.",
        [rostest("kill_node")],
    ),
    Check(
        "benchmark_trunk",
        "One Newton step and the quadratic programmes of the shipped trunk on one core, and the share of a core that its "
        "simulation takes.",
        ["benchmark_trunk"],
    ),
)
BY_NAME = {check.name: check for check in CHECKS}
