"""Variants of camera files, as OpenCV's FileStorage and ROS write them."""
import json

MATRIX = [1108.5, 0, 645.2, 0, 1106.0, 352.8, 0, 0, 1]
LENS = [-0.12, 0.06, 0.0008, -0.0006, 0.0]
# The pose of the first image's needle with the camera that made the images.
VALUES = [["first [^,]*,(-?[0-9.e-]+)", None, 1.0]]


def opencv_yaml(matrix=MATRIX, lens=LENS, size=(1280, 720), names=("camera_matrix", "distortion_coefficients"), more="",
                head="%YAML:1.0\n---\n"):
    rows = lambda values, r, c: (f"!!opencv-matrix\n   rows: {r}\n   cols: {c}\n   dt: d\n"
                                 f"   data: [ {', '.join(map(str, values))} ]\n")
    return (f"{head}image_width: {size[0]}\nimage_height: {size[1]}\n{names[0]}: {rows(matrix, 3, 3)}"
            f"{names[1]}: {rows(lens, len(lens), 1)}{more}")


def opencv_xml(matrix=MATRIX, lens=LENS, size=(1280, 720), root="opencv_storage", more="", head='<?xml version="1.0"?>\n'):
    rows = lambda name, values, r, c: (f'<{name} type_id="opencv-matrix">\n  <rows>{r}</rows>\n  <cols>{c}</cols>\n'
                                       f"  <dt>d</dt>\n  <data>\n    {' '.join(map(str, values))}</data></{name}>\n")
    return (f"{head}<{root}>\n<image_width>{size[0]}</image_width>\n<image_height>{size[1]}</image_height>\n"
            f"{rows('camera_matrix', matrix, 3, 3)}{rows('distortion_coefficients', lens, len(lens), 1)}{more}</{root}>\n")


def ros(model="plumb_bob", lens=LENS, size=(1280, 720), matrix=MATRIX):
    rows = lambda name, values, r, c: (f"{name}:\n  rows: {r}\n  cols: {c}\n  data: [{', '.join(map(str, values))}]\n")
    return (f"image_width: {size[0]}\nimage_height: {size[1]}\ncamera_name: head_camera\n{rows('camera_matrix', matrix, 3, 3)}"
            f"distortion_model: {model}\n{rows('distortion_coefficients', lens, 1, len(lens))}"
            f"{rows('rectification_matrix', [1, 0, 0, 0, 1, 0, 0, 0, 1], 3, 3)}"
            f"{rows('projection_matrix', [1000, 0, 640, 0, 0, 1000, 360, 0, 0, 0, 1, 0], 3, 4)}")


def cases(w):
    def of(name, text, exits=(0,), ending=".yml", **more):
        path = w / f"camera_{name}{ending}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return {"kind": "cameras", "name": f"camera_{name}", "exit": list(exits),
                "command": f"acus-camera track $CAMERA_SAMPLE/facets --camera '{path}' -o out",
                "measure": ("camera", "out", w.parent / "camera_sample/truth"),
                "values": [["off_mm ([0-9.e-]+)", 0, 2.0]], **more}
    plain = opencv_yaml()
    yield of("opencv", plain)
    yield of("opencv_crlf", plain.replace("\n", "\r\n"))
    yield of("opencv_date", opencv_yaml(more='calibration_time: "Mon 04 Mar 2024 10:00:00"\nnframes: 20\nflags: 0\n'))
    yield of("opencv_no_header", opencv_yaml(head=""), (0, 3))
    yield of("opencv_capitals", opencv_yaml(names=("Camera_Matrix", "Distortion_Coefficients")))
    yield of("opencv_eight_zeros", opencv_yaml(lens=LENS + [0, 0, 0]))
    yield of("opencv_four", opencv_yaml(lens=LENS[:4]))
    yield of("opencv_rational", opencv_yaml(lens=LENS + [0.3, 0.1, 0.01]), (3,))
    yield of("opencv_fisheye", opencv_yaml(lens=LENS[:4], more="fisheye_model: 1\n"), (3,), says=["fisheye"])
    yield of("opencv_not_fisheye", opencv_yaml(more="fisheye_model: 0\n"))
    yield of("opencv_no_size", "\n".join(line for line in plain.split("\n") if "image_width" not in line), (3,))
    yield of("opencv_no_lens", plain[:plain.index("distortion")], (3,))
    yield of("opencv_transposed", opencv_yaml(matrix=[MATRIX[i] for i in (0, 3, 6, 1, 4, 7, 2, 5, 8)]), (3,))
    yield of("opencv_skew", opencv_yaml(matrix=[1108.5, 3, *MATRIX[2:]]), (3,))
    yield of("opencv_normalised", opencv_yaml(matrix=[0.866, 0, 0.504, 0, 1.536, 0.49, 0, 0, 1]), (3,))
    yield of("opencv_nan", opencv_yaml(matrix=[".Nan", *MATRIX[1:]]), (3,))
    yield of("opencv_other_size", opencv_yaml(size=(640, 480)), (3,))
    yield of("opencv_cut", plain[:200], (3,), may_be_cut=True)
    yield of("opencv_xml", opencv_xml(), ending=".xml")
    yield of("opencv_xml_crlf", opencv_xml().replace("\n", "\r\n"), ending=".xml")
    yield of("opencv_xml_comment", opencv_xml(head='<?xml version="1.0"?>\n<!-- a camera -->\n'), (0, 3), ending=".xml")
    yield of("opencv_xml_utf8", opencv_xml(head='<?xml version="1.0" encoding="UTF-8"?>\n'), (0, 3), ending=".xml")
    yield of("opencv_xml_fisheye", opencv_xml(more="<fisheye_model>1</fisheye_model>"), (3,), ending=".xml")
    yield of("opencv_xml_other_root", opencv_xml(root="calibration"), (3,), ending=".xml", says=["opencv_storage"])
    yield of("opencv_xml_cut", opencv_xml()[:300], (3,), ending=".xml", may_be_cut=True)
    yield of("opencv_xml_deep", opencv_xml(more="<a>" * 900 + "</a>" * 900), (3,), ending=".xml")
    yield of("yaml_as_xml", plain, (3,), ending=".xml")
    yield of("ros", ros(), ending=".yaml")
    yield of("ros_quoted", ros().replace("plumb_bob", '"plumb_bob"'), (0, 3), ending=".yaml")
    yield of("ros_rational", ros("rational_polynomial", LENS + [0, 0, 0]), (0, 3), ending=".yaml")
    yield of("ros_fisheye", ros("equidistant", LENS[:4]), (3,), ending=".yaml")
    yield of("ros_zero", ros(matrix=[0] * 9, lens=[]), (3,), ending=".yaml")
    yield of("kalibr", "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0.1, 0.2, 0, 0]\n"
             "  distortion_model: equidistant\n  intrinsics: [1108.5, 1106, 645.2, 352.8]\n  resolution: [1280, 720]\n",
             (3,), ending=".yaml")
    yield of("empty", "", (3,))
    yield of("json_of_calibration", json.dumps({"camera_matrix": MATRIX, "dist_coeff": LENS}), (3,), ending=".json")
