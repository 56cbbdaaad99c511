"""Reads a map as map_server of ROS does: a YAML file and an image.

Rule 1: a cell is free where map_server would publish 0, by its documentation and in ROS 1 as in ROS 2. All
        other cells are blocked: occupied, unknown, or only perhaps occupied (modes scale and raw).
Rule 2: where the documentation is silent or versions differ, a cell is blocked, or the map is refused: a
        transparent pixel is blocked in every mode, and raw with negate is refused.
Rule 3: files and images have bounded sizes, and an image is refused by its size before it is decoded.
"""

import warnings
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np
from msgspec import Meta, Struct

from protocol.arrays import Flags, Indices
from protocol.errors import UsageError
from protocol.files.opening import read_bytes
from protocol.files.reading import understand
from protocol.frames import Metres
from world.scenario.reading import MAP_IMAGES

PIXELS_MAX = 1 << 24  # 4096 x 4096: one more than gmapping's usual 4000 x 4000
HEADER_BYTES_MAX = 1 << 16
IMAGE_BYTES_MAX = 5 * PIXELS_MAX  # as decimal numbers (P2), the longest form, with some slack
FORMATS = ("PPM", "PNG", "BMP")  # what map_saver writes; Pillow reads PGM, plain or not, as PPM
SAVED_UNKNOWN = 205  # the grey by which map_saver writes unknown cells

TEXTS = {"image", "mode"}
Scalar = str | int | float | None
Threshold = Annotated[float, Meta(ge=0.0, le=1.0)]


class Header(Struct, frozen=True, kw_only=True):
    """The fields of the YAML file; others are ignored, as map_server does."""

    image: Annotated[str, Meta(min_length=1, max_length=4096)]
    resolution: Annotated[float, Meta(ge=1e-3, le=1e3, description="m per cell")]
    origin: Annotated[tuple[Metres, Metres, Metres], Meta(description="x, y, yaw of the lower left corner")]
    negate: bool | Annotated[int, Meta(ge=0, le=1)]
    occupied_thresh: Threshold
    free_thresh: Threshold
    mode: Literal["trinary", "scale", "raw"] = "trinary"

    def __post_init__(self) -> None:
        if self.free_thresh > self.occupied_thresh:
            rule = f"must be <= occupied_thresh = {self.occupied_thresh:g}"
            raise ValueError(f"$.free_thresh: {rule}, got {self.free_thresh:g}")
        if self.mode == "raw" and self.negate:
            raise ValueError(
                "$.negate: must be 0 in mode raw, which map servers read in different ways, got 1"
            )

    def free(self, most: int) -> Flags:
        """Rule 1: whether a cell is free, for each value of a pixel from 0 to `most`."""
        values = np.arange(most + 1)
        if self.mode == "raw":
            return np.asarray(values == 0)
        occupancy = (values if self.negate else most - values) / most
        return np.asarray(occupancy < self.free_thresh)


@dataclass(frozen=True, kw_only=True)
class Map:
    """The cells of a map that are not known to be free, and where they are."""

    blocked: Flags
    """`(rows, columns)`; the first row is the lowest."""
    resolution_m: float
    origin: tuple[float, float, float]
    """Of the lower left corner: x, y, yaw [m, rad; world frame]."""
    doubtful: int
    """Free cells that have the grey by which map_saver writes unknown ones."""


def read_map(path: Path) -> Map:
    """The map of a YAML file.

    Raises:
        UsageError: the file or its image cannot be read, or is no map; one line says why.
    """
    source = str(path)
    if path.suffix.lower() in MAP_IMAGES:
        raise UsageError(f"{source}: is an image; give the YAML file beside it")
    header = understand(_yaml(path, source), Header, source)
    values, most, opaque = _pixels(path.parent / header.image, source)
    free = header.free(most)[values] & opaque
    grey = header.mode == "trinary" and not header.negate
    return Map(
        blocked=~free[::-1],
        resolution_m=header.resolution,
        origin=header.origin,
        doubtful=int((free & (values * 255 == SAVED_UNKNOWN * most)).sum()) if grey else 0,
    )


def _yaml(path: Path, source: str) -> dict[str, object]:
    """The fields that we know, unchecked, but no nested ones: by aliases those can be huge when printed."""
    try:
        said: object = msgspec.yaml.decode(_bytes(path, source, HEADER_BYTES_MAX))
    except (msgspec.DecodeError, ValueError, RecursionError) as error:
        raise UsageError(f"{source}: is not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(said, dict):
        raise UsageError(f"{source}: $: must have fields, such as `image: map.pgm`")
    fields = {name: said[name] for name in Header.__struct_fields__ if name in said}
    for name, value in fields.items():
        values = value if isinstance(value, list) else [value]
        if not all(isinstance(each, Scalar) for each in values):
            raise UsageError(f"{source}: $.{name}: must be a number, a text or a list of these")
        if name not in TEXTS:
            fields[name] = [_number(each) for each in values] if isinstance(value, list) else _number(value)
    return fields


def _number(value: object) -> object:
    """Map servers take 1e-05 for a number, as yaml-cpp writes it; for PyYAML it is a text."""
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value


def _bytes(path: Path, source: str, bytes_max: int) -> bytes:
    try:
        return read_bytes(path, bytes_max)
    except (OSError, ValueError) as error:  # a null character in a path is a ValueError
        what = "cannot be read" if source == str(path) else f"$.image: cannot read {path}"
        raise UsageError(f"{source}: {what}: {getattr(error, 'strerror', error)}") from error


def _pixels(path: Path, source: str) -> tuple[Indices, int, Flags]:
    """The value of each pixel, the value of white, and whether the pixel is opaque."""
    from PIL import Image, UnidentifiedImageError  # noqa: PLC0415 - an extra

    content = _bytes(path, source, IMAGE_BYTES_MAX)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            image = Image.open(BytesIO(content), formats=FORMATS)
        if image.width * image.height > PIXELS_MAX:
            raise ValueError(f"it has {image.width} x {image.height} pixels, more than {PIXELS_MAX}")
        if image.mode.startswith("I"):  # 16 bits of grey
            values = np.asarray(image).astype(np.intp)
            return values, 65535, np.full(values.shape, fill_value=True)
        colours = np.asarray(image.convert("RGBA"))
    except UnidentifiedImageError as error:  # which names an object of ours
        raise UsageError(f"{source}: $.image: {path} is no valid PGM, PNG or BMP") from error
    except Exception as error:  # of a damaged image, Pillow raises errors of many kinds
        raise UsageError(f"{source}: $.image: {path} cannot be decoded: {error}") from error
    return colours[..., :3].sum(axis=2, dtype=np.intp), 3 * 255, colours[..., 3] == 255
