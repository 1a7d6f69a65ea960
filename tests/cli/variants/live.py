"""Variants of live streams: what a sender of OpenIGTLink may do."""
import pathlib

SERVER = pathlib.Path(__file__).absolute().parent / "igtl_server.py"
SEEN = {"never": ["does not see the probe"]}
NOT_SEEN = {
    "version_4": "no OpenIGTLink messages of versions 1 to 3", "metadata_not_seen": "says that it is not in view",
    "crc_zero": "wrong checksum, named ProbeToReference", "crc_wrong": "wrong checksum, named ProbeToReference",
    "lower_case": "same case", "upper_case": "same case", "other_name": "names received: ProbeToTracker",
    "blank_behind": "names received: .?ProbeToReference", "scaled_5_percent": "not rigid: .* by 0.10",
    "scaled_metres": "not rigid", "mirrored": "mirrored", "sheared": "not rigid: .* by 0.1", "all_zero": "not rigid",
    "not_a_number": "not finite", "status_only": "kinds that carry no pose", "text_only": "kinds that carry no pose",
    "size_wrong": "no OpenIGTLink messages", "size_huge": "no message", "text_of_http": "no OpenIGTLink messages|did not finish a message",
    "silent": "no message",
}
SEEN_MODES = ("plain", "version_2", "version_2_metadata", "version_3", "others_between", "two_at_once", "time_zero",
              "clock_ahead", "scaled_by_float", "qtdata", "tdata", "position", "junk_before")


def cases(w):
    for mode in (*SEEN_MODES, *NOT_SEEN):
        says = {"says": [NOT_SEEN[mode]]} if mode in NOT_SEEN else SEEN
        yield {"kind": "igtl", "waits": True, "name": f"igtl_{mode}", "exit": [0], **says,
               "command": f"python3 {SERVER} {mode} 10 devices.json & while [ ! -f devices.json ]; do sleep 0.02; done; "
                          "acus-live $SCENARIO --set /patient/ct=$PATIENT/ct.nrrd --set /patient/labels=$PATIENT/"
                          "labels.seg.nrrd --set /patient/ct_from_reference_file=$PATIENT/ct_from_reference.tfm "
                          "--devices devices.json --headless --duration 3 -o out; code=$?; kill %1 2>/dev/null; exit $code"}
