// The map as SVG: a canvas context that writes down what is drawn on it. It knows the calls that a map makes.

const PLAIN = { strokeStyle: "#000", fillStyle: "#000", lineWidth: 1, lineJoin: "miter", globalAlpha: 1, font: "10px sans-serif", textAlign: "start", textBaseline: "alphabetic" };
const ANCHORS = /** @type {Record<string, string>} */ ({ center: "middle", right: "end" });
const BASELINES = /** @type {Record<string, string>} */ ({ middle: "central", top: "hanging" });

class SvgContext {
  /** @param {number} width px @param {number} height px */
  constructor(width, height) {
    this.ratio = window.devicePixelRatio || 1;
    this.canvas = { width: width * this.ratio, height: height * this.ratio };
    this.style = { ...PLAIN, dash: /** @type {number[]} */ ([]), scale: 1, flip: 1, x: 0, y: 0 };
    /** @type {(typeof this.style)[]} */
    this.styles = [];
    this.path = new Outline();
    /** @type {string[]} */
    this.parts = [];
    for (const name of Object.keys(PLAIN))
      Object.defineProperty(this, name, {
        get: () => /** @type {any} */ (this.style)[name],
        set: (value) => (/** @type {any} */ (this.style)[name] = value),
      });
  }

  save() {
    this.styles.push({ ...this.style });
  }

  restore() {
    this.style = this.styles.pop() ?? this.style;
  }

  /** @param {number} a @param {number} _b @param {number} _c @param {number} d @param {number} x @param {number} y */
  setTransform(a, _b, _c, d, x, y) {
    Object.assign(this.style, { scale: a / this.ratio, flip: Math.sign(d), x: x / this.ratio, y: y / this.ratio });
  }

  /** @param {number} x @param {number} y */
  translate(x, y) {
    [this.style.x, this.style.y] = this.at(x, y);
  }

  /** @param {number} x @param {number} y @returns {[number, number]} px */
  at(x, y) {
    const { scale, flip } = this.style;
    return [this.style.x + scale * x, this.style.y + flip * scale * y];
  }

  /** @param {number[]} dash */
  setLineDash(dash) {
    this.style.dash = dash;
  }

  beginPath() {
    this.path = new Outline();
  }

  /** @param {number} x @param {number} y */
  moveTo(x, y) {
    this.path.moveTo(x, y);
  }

  /** @param {number} x @param {number} y */
  lineTo(x, y) {
    this.path[this.path.said.length ? "lineTo" : "moveTo"](x, y);
  }

  /** @param {number} x @param {number} y @param {number} radius @param {number} from @param {number} to */
  arc(x, y, radius, from, to) {
    this.path.arc(x, y, radius, from, to);
  }

  closePath() {
    this.path.closePath();
  }

  /** @param {Outline} [outline] */
  fill(outline = this.path) {
    this.put("path", { d: this.way(outline), fill: this.style.fillStyle, opacity: this.style.globalAlpha });
  }

  /** @param {Outline} [outline] */
  stroke(outline = this.path) {
    this.put("path", { d: this.way(outline), fill: "none", ...this.line() });
  }

  /** @param {number} x @param {number} y @param {number} width @param {number} height */
  strokeRect(x, y, width, height) {
    const outline = new Outline();
    outline.rect(x, y, width, height);
    this.stroke(outline);
  }

  /** @param {string} text @param {number} x @param {number} y */
  fillText(text, x, y) {
    this.put("text", { ...this.word(x, y), fill: this.style.fillStyle, opacity: this.style.globalAlpha }, text);
  }

  /** @param {string} text @param {number} x @param {number} y */
  strokeText(text, x, y) {
    this.put("text", { ...this.word(x, y), fill: "none", ...this.line() }, text);
  }

  /** @param {string} text */
  measureText(text) {
    scratch.font = this.style.font;
    return scratch.measureText(text);
  }

  line() {
    const { strokeStyle, lineWidth, lineJoin, dash, scale, globalAlpha } = this.style;
    const dashes = dash.map((each) => short(each * scale)).join(" ");
    return { stroke: strokeStyle, "stroke-width": short(lineWidth * scale), "stroke-linejoin": lineJoin, "stroke-dasharray": dashes || "none", opacity: globalAlpha };
  }

  /** @param {number} x @param {number} y */
  word(x, y) {
    const [px, py] = this.at(x, y);
    const { font, textAlign, textBaseline } = this.style;
    return { x: short(px), y: short(py), style: `font: ${font}`, "text-anchor": ANCHORS[textAlign] ?? "start", "dominant-baseline": BASELINES[textBaseline] ?? "auto" };
  }

  /** @param {Outline} outline */
  way(outline) {
    return outline.said.map(([sign, ...numbers], i) => (sign === "A" ? this.bow(/** @type {number[]} */ (numbers), i > 0) : sign === "Z" ? "Z" : this.to(i ? String(sign) : "M", Number(numbers[0]), Number(numbers[1])))).join("");
  }

  /** @param {string} sign @param {number} x @param {number} y */
  to(sign, x, y) {
    return sign + this.at(x, y).map(short).join(" ");
  }

  /** Part of an ellipse: in two, since all round has no direction. @param {number[]} bow @param {boolean} goesOn */
  bow([x, y, a, b, turn, from, to], goesOn) {
    const { scale, flip } = this.style;
    const on = (/** @type {number} */ angle) => {
      const [u, v] = [a * Math.cos(angle), b * Math.sin(angle)];
      return this.at(x + u * Math.cos(turn) - v * Math.sin(turn), y + u * Math.sin(turn) + v * Math.cos(turn)).map(short).join(" ");
    };
    const half = `A${short(a * scale)} ${short(b * scale)} ${short((flip * turn * 180) / Math.PI)} 0 ${flip > 0 ? 1 : 0} `;
    return `${goesOn ? "L" : "M"}${on(from)}${half}${on((from + to) / 2)}${half}${on(to)}`;
  }

  /** @param {string} tag @param {Record<string, string | number>} attributes @param {string} text */
  put(tag, attributes, text = "") {
    const said = Object.entries(attributes).map(([name, value]) => ` ${name}="${escaped(String(value))}"`);
    this.parts.push(`<${tag}${said.join("")}>${escaped(text)}</${tag}>`);
  }

  /** The whole; the page's own SVG knows the address of its kind, and the page itself holds none. @param {string} ground */
  text(ground) {
    const [width, height] = [this.canvas.width / this.ratio, this.canvas.height / this.ratio];
    const head = `<svg xmlns="${document.querySelector("svg")?.namespaceURI}" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">`;
    return `${head}<rect width="${width}" height="${height}" fill="${ground}"/>\n${this.parts.join("\n")}\n</svg>\n`;
  }
}

/** @param {number} value */
function short(value) {
  return Math.round(value * 100) / 100;
}

/** @param {string} text */
function escaped(text) {
  return text.replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`);
}
