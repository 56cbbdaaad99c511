"""Records what a page draws: every stroke, fill and word on its canvases, with its coordinates."""

from collections import Counter

import msgspec
from msgspec import Struct

from tests.support.pages.browser import Sight

RECORD = """(() => {
  const calls = (window.drawn = []), paths = new WeakMap(), stills = new Map();
  const nameOf = (canvas) => {
    if (canvas.closest("#panes")) return "map";
    if (canvas.isConnected) return canvas.id || "chart";
    if (!stills.has(canvas)) stills.set(canvas, `still ${stills.size}`);
    return stills.get(canvas);
  };
  const pathOf = (of) => {
    if (!paths.has(of)) paths.set(of, { points: [], arcs: [] });
    return paths.get(of);
  };
  for (const { prototype } of [CanvasRenderingContext2D, Path2D]) {
    for (const name of ["moveTo", "lineTo", "arc"]) {
      const plain = prototype[name];
      prototype[name] = function (...said) {
        const path = pathOf(this);
        (name === "arc" ? path.arcs : path.points).push(said.slice(0, name === "arc" ? 3 : 2));
        return plain.apply(this, said);
      };
    }
  }
  const note = (context, does, path, text) => calls.push({
    on: nameOf(context.canvas), does, text,
    style: does === "stroke" ? context.strokeStyle : context.fillStyle,
    width_px: context.lineWidth * context.getTransform().a,
    dashed: context.getLineDash().length > 0,
    points: [...path.points], arcs: [...path.arcs],
  });
  const { prototype } = CanvasRenderingContext2D;
  const { beginPath, fill, stroke, fillText, fillRect } = prototype;
  prototype.beginPath = function () { paths.delete(this); return beginPath.call(this); };
  for (const [does, plain] of [["fill", fill], ["stroke", stroke]]) {
    prototype[does] = function (...said) {
      note(this, does, pathOf(said[0] ?? this), "");
      return plain.apply(this, said);
    };
  }
  prototype.fillText = function (text, x, y) {
    note(this, "text", { points: [[x, y]], arcs: [] }, text);
    return fillText.call(this, text, x, y);
  };
  prototype.fillRect = function (x, y, width, height) {
    note(this, "rect", { points: [[x, y], [x + width, y + height]], arcs: [] }, "");
    return fillRect.call(this, x, y, width, height);
  };
})();"""


class Mark(Struct, frozen=True):
    """One stroke, fill, rectangle or word."""

    on: str
    """`map`, `lanes`, `chart`, or `still 3`: a picture that is drawn once and shown in one of these."""
    does: str
    text: str
    style: str
    width_px: float
    dashed: bool
    points: list[tuple[float, float]]
    """On a layer of the map [m; world frame]; else [px]."""
    arcs: list[tuple[float, float, float]]
    """Centre and radius."""


def record(shown: Sight) -> None:
    """Record everything that is drawn from now on; call it before the page is opened."""
    shown.page.add_init_script(RECORD)


def drawn(shown: Sight, t_s: float) -> list[Mark]:
    """The drawing of this moment."""
    said = shown.page.evaluate(f"drawn.length = 0; clew.seek({t_s}); clew.draw(); drawn")
    return msgspec.convert(said, list[Mark])


def layer(shown: Sight, name: str, t_s: float) -> list[Mark]:
    """The drawing of this map layer alone at a moment, in drawing order."""
    press = "document.querySelectorAll('#layers [aria-pressed=\"%s\"]%s').forEach((chip) => chip.click())"
    shown.page.evaluate(press % ("true", ""))
    without = Counter(map(str, drawn(shown, t_s)))
    shown.page.evaluate(press % ("false", f"[data-layer={name}]"))
    found = list[Mark]()
    for mark in drawn(shown, t_s):
        without[str(mark)] -= 1
        if mark.on == "map" and without[str(mark)] < 0:
            found.append(mark)
    shown.page.evaluate(press % ("false", ""))
    return found
