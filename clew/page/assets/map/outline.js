// Paths of a map, which a canvas draws and an SVG writes down.

/** A path that can be drawn, and written down. */
class Outline extends Path2D {
  constructor() {
    super();
    /** @type {(string | number)[][]} */
    this.said = [];
  }

  /** @param {number} x @param {number} y */
  moveTo(x, y) {
    super.moveTo(x, y);
    this.said.push(["M", x, y]);
  }

  /** @param {number} x @param {number} y */
  lineTo(x, y) {
    super.lineTo(x, y);
    this.said.push(["L", x, y]);
  }

  /** @param {number} x @param {number} y @param {number} radius @param {number} from @param {number} to */
  arc(x, y, radius, from, to) {
    super.arc(x, y, radius, from, to);
    this.said.push(["A", x, y, radius, radius, 0, from, to]);
  }

  /** @param {number} x @param {number} y @param {number} a @param {number} b @param {number} turn @param {number} from @param {number} to */
  ellipse(x, y, a, b, turn, from, to) {
    super.ellipse(x, y, a, b, turn, from, to);
    this.said.push(["A", x, y, a, b, turn, from, to]);
  }

  /** @param {number} x @param {number} y @param {number} width @param {number} height */
  rect(x, y, width, height) {
    super.rect(x, y, width, height);
    this.said.push(["M", x, y], ["L", x + width, y], ["L", x + width, y + height], ["L", x, y + height], ["Z"]);
  }

  closePath() {
    super.closePath();
    this.said.push(["Z"]);
  }
}
