"""A map is read as map_server documents it; what is wrong with one is said in a line."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from clew.maps import occupancy
from clew.maps.occupancy import Map, read_map
from protocol.errors import UsageError
from tests.support.scenes.maps import FIELDS, written

SHADES = [[0, 89, 90, 205], [206, 254, 255, 1]]  # p: 1, 0.65098, 0.647, 0.19608; 0.192, 0.004, 0, 0.996


def free(read: Map) -> list[list[int]]:
    """The free cells, in the order of the image."""
    cells: list[list[int]] = (~read.blocked[::-1]).astype(int).tolist()
    return cells


@pytest.mark.parametrize(
    ("fields", "wanted"),
    [
        ({}, [[0, 0, 0, 0], [1, 1, 1, 0]]),
        ({"mode": "scale"}, [[0, 0, 0, 0], [1, 1, 1, 0]]),
        ({"negate": 1}, [[1, 0, 0, 0], [0, 0, 0, 1]]),
        ({"negate": "true"}, [[1, 0, 0, 0], [0, 0, 0, 1]]),
        ({"mode": "raw"}, [[1, 0, 0, 0], [0, 0, 0, 0]]),
        ({"free_thresh": 0}, [[0, 0, 0, 0], [0, 0, 0, 0]]),
        ({"free_thresh": 0.25}, [[0, 0, 0, 1], [1, 1, 1, 0]]),
    ],
)
def test_cells_are_free_where_map_server_says_0(
    tmp_path: Path, fields: dict[str, object], wanted: list[list[int]]
) -> None:
    assert free(read_map(written(tmp_path, SHADES, **fields))) == wanted


def as_text(path: Path, shades: np.ndarray) -> None:
    rows = "\n".join(" ".join(map(str, row)) for row in shades.tolist())
    path.write_text(f"P2\n# drawn\n{shades.shape[1]} {shades.shape[0]}\n255\n{rows}\n", encoding="ascii")


FORMS: dict[str, Callable[[Path, np.ndarray], None]] = {
    "P2": as_text,
    "P5 of 16 bits": lambda path, shades: Image.fromarray(shades.astype(np.uint16) * 257).save(path, "PPM"),
    "PNG": lambda path, shades: Image.fromarray(shades).save(path, "PNG"),
    "PNG of 16 bits": lambda path, shades: Image.fromarray(shades.astype(np.uint16) * 257).save(path, "PNG"),
    "PNG in colour": lambda path, shades: Image.fromarray(shades).convert("RGB").save(path, "PNG"),
    "PNG with a palette": lambda path, shades: Image.fromarray(shades).convert("P").save(path, "PNG"),
    "BMP": lambda path, shades: Image.fromarray(shades).save(path, "BMP"),
}


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_every_form_of_an_image_is_the_same_map(
    tmp_path: Path, form: Callable[[Path, np.ndarray], None]
) -> None:
    shades = np.array(SHADES, dtype=np.uint8)
    usual = read_map(written(tmp_path, SHADES))
    form(tmp_path / "map.pgm", shades)
    assert np.array_equal(read_map(tmp_path / "map.yaml").blocked, usual.blocked)


def test_colours_are_averaged_and_what_is_transparent_is_not_free(tmp_path: Path) -> None:
    path = written(tmp_path, SHADES)
    white, light, grey = (255, 255, 255), (255, 255, 110), (255, 255, 100)  # light: the average is 206.7
    colours = np.array([[(*white, 255), (*white, 254), (*light, 255), (*grey, 255)]], dtype=np.uint8)
    Image.fromarray(colours).save(tmp_path / "map.pgm", "PNG")
    assert free(read_map(path)) == [[1, 0, 1, 0]]


def test_the_first_row_is_the_lowest_and_the_yaml_may_have_lists_in_blocks(tmp_path: Path) -> None:
    read = read_map(written(tmp_path, [[255], [0]], origin="\n- -1.5\n- 2\n- 0.5\nunknown: {}"))
    assert read.blocked.tolist() == [[True], [False]]
    assert (read.resolution_m, read.origin) == (0.5, (-1.5, 2.0, 0.5))


def test_a_number_may_be_written_as_cpp_does(tmp_path: Path) -> None:
    read = read_map(written(tmp_path, [[255]], resolution="5e-2", origin="[-1e-05, '2', 0]"))
    assert (read.resolution_m, read.origin) == (0.05, (-1e-05, 2.0, 0.0))


def test_free_cells_of_the_grey_for_unknown_are_counted(tmp_path: Path) -> None:
    assert read_map(written(tmp_path, SHADES)).doubtful == 0
    assert read_map(written(tmp_path, SHADES, free_thresh=0.25)).doubtful == 1


BOMB = "[]]\na: &a [z, z]\nb: &b [*a, *a]\nimage: [*b"
REFUSED: dict[str, tuple[dict[str, object], str]] = {
    "no image": ({"image": "other.pgm"}, "other.pgm: No such file or directory"),
    "a folder": ({"image": "."}, "Is a directory"),
    "not an image": ({"image": "map.yaml"}, "map.yaml is no valid PGM, PNG or BMP"),
    "no resolution": ({"resolution": None}, "$: must have the field resolution, got image,"),
    "a text": ({"resolution": "wide"}, "$.resolution: must be a number, got 'wide'"),
    "no length": ({"resolution": 0}, "$.resolution: must be >= 0.001, got 0"),
    "nan": ({"resolution": ".nan"}, "$.resolution: must be >= 0.001, got nan"),
    "infinite": ({"origin": "[.inf, 0, 0]"}, "$.origin[0]: must be"),
    "two numbers": ({"origin": "[0, 0]"}, "$.origin"),
    "a mode": ({"mode": "trinray"}, "did you mean 'trinary'?"),
    "negate": ({"negate": 2}, "$.negate: must be <= 1, got 2"),
    "raw": ({"negate": 1, "mode": "raw"}, "$.negate: must be 0 in mode raw"),
    "thresholds": ({"free_thresh": 0.7}, "$.free_thresh: must be <= occupied_thresh = 0.65, got 0.7"),
    "no YAML": ({"origin": "[0, 0"}, "is not YAML: "),
    "nested": (
        {"origin": BOMB.replace("[]]", "0").replace("image", "origin") + "]"},
        "$.origin: must be a number,",
    ),
}


@pytest.mark.parametrize(("fields", "said"), REFUSED.values(), ids=REFUSED)
def test_a_wrong_map_is_refused_in_a_line(tmp_path: Path, fields: dict[str, object], said: str) -> None:
    path = written(tmp_path, SHADES, **fields)
    with pytest.raises(UsageError) as refusal:
        read_map(path)
    assert str(refusal.value).startswith(f"{path}: ")
    assert said in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"P5\n4 2\n255\n1234567", "cannot be decoded"),
        (b"P5\n4097 4096\n255\n", "4097 x 4096 pixels, more than 16777216"),
        (b"P5\n20000 20000\n255\n", "decompression bomb"),
        (b"P5\n10000 10000\n255\n", "decompression bomb"),
        (b"P5\n0 2\n255\n", "no valid PGM"),
        (b"", "no valid PGM, PNG or BMP"),
        (b"GIF89a" + bytes(60), "no valid PGM, PNG or BMP"),
    ],
)
def test_a_wrong_image_is_refused_in_a_line(tmp_path: Path, content: bytes, said: str) -> None:
    path = written(tmp_path, SHADES)
    (tmp_path / "map.pgm").write_bytes(content)
    with pytest.raises(UsageError, match=said) as refusal:
        read_map(path)
    assert "\n" not in str(refusal.value)


def test_files_that_are_too_long_are_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(tmp_path, SHADES)
    monkeypatch.setattr(occupancy, "IMAGE_BYTES_MAX", 10)
    with pytest.raises(UsageError, match=r"map\.pgm: it is longer than 10 bytes"):
        read_map(path)
    path.write_text("#" * (occupancy.HEADER_BYTES_MAX + 1), encoding="ascii")
    with pytest.raises(UsageError, match=r"cannot be read: it is longer than 65536 bytes"):
        read_map(path)


@pytest.mark.parametrize("text", ["", "map", "- image", "[" * 5000])
def test_a_file_without_fields_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "map.yaml").write_text(text, encoding="ascii")
    with pytest.raises(UsageError, match=r"must have fields|is not YAML"):
        read_map(tmp_path / "map.yaml")


def test_every_field_but_the_mode_is_needed() -> None:
    assert set(FIELDS) == set(occupancy.Header.__struct_fields__) - {"mode"}
