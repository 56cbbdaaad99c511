// How things look: colours by theme, and what tells robots apart without colour: their numbers and their dashes.

const ROBOT_COLOURS = {
  light: ["#0a6a9f", "#bd3f0b", "#0b7457", "#86398f", "#8f6200", "#3d56b0", "#ab234a", "#47661a"],
  dark: ["#5db8ee", "#ff9a5c", "#4fd0a6", "#d599e0", "#e3b341", "#9aaefb", "#f5879f", "#aed36f"],
};

/** Dashes of a robot's lines [px]; colours repeat after 8 robots, dashes after 5. */
const DASHES = [[], [7, 3], [2, 2.5], [9, 3, 2, 3], [14, 3]];

/** @type {Record<string, string>} the colours in use, by the name of their CSS variable */
const colour = {};

/** Read the colours of the theme in use. */
function readTheme() {
  const style = getComputedStyle(document.documentElement);
  for (const name of [
    "paper",
    "card",
    "ink",
    "soft",
    "faint",
    "rule",
    "solid",
    "solid-edge",
    "good",
    "bad",
    "warn",
    "promise",
    "scan",
  ]) {
    colour[name] = style.getPropertyValue(`--${name}`).trim();
  }
  const isDark = style.colorScheme.trim() === "dark";
  robotColours = isDark ? ROBOT_COLOURS.dark : ROBOT_COLOURS.light;
}

let robotColours = ROBOT_COLOURS.light;

/** @param {number} robot 0: what is of no single robot */
function colourOf(robot) {
  if (robot === 0) return colour.ink;
  return robotColours[(robot - 1) % robotColours.length];
}

/** @param {number} robot */
function dashOf(robot) {
  return robot === 0 ? [] : DASHES[(robot - 1) % DASHES.length];
}

/**
 * A canvas as large as its place on the page, and as sharp as the screen.
 * @param {HTMLCanvasElement} canvas @returns {{context: CanvasRenderingContext2D, width: number, height: number}}
 */
function surfaceOf(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { context, width, height };
}

/** A picture that is drawn again only when what it depends on has changed. */
class Still {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.key = "";
  }

  /**
   * @param {CanvasRenderingContext2D} onto @param {number} width @param {number} height @param {string} key
   * @param {(context: CanvasRenderingContext2D) => void} draw
   */
  show(onto, width, height, key, draw) {
    const ratio = window.devicePixelRatio || 1;
    const whole = `${key}|${width}|${height}|${ratio}|${colour.paper}`;
    if (whole !== this.key) {
      this.key = whole;
      this.canvas.width = Math.max(Math.round(width * ratio), 1);
      this.canvas.height = Math.max(Math.round(height * ratio), 1);
      const context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d"));
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      draw(context);
    }
    onto.drawImage(this.canvas, 0, 0, width, height);
  }
}

const FONT = "ui-sans-serif, system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', sans-serif";

/** @param {number} size px @param {string} [weight] */
function font(size, weight = "400") {
  return `${weight} ${size}px ${FONT}`;
}

/** Steps of an axis: round numbers, about `count` of them. @param {number} span @param {number} count */
function roundStep(span, count) {
  const rough = span / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].map((each) => each * power).find((each) => each >= rough) ?? 10 * power;
}
