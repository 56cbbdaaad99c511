// Where one robot's body is: its track, as a column of places between which it goes straight and evenly.

const CHUNK = 128; // places in one piece of a trail: few pieces to draw, little to draw point by point
const PIECES_SHOWN = 24; // of a trail, the newest: some ten minutes of driving round corners

const UNTIL_SAMPLED_S = 0.15; // a body that moves is sampled every 0.1 s: until then it goes on as it did

class Body {
  /** @param {number} robot */
  constructor(robot) {
    this.robot = robot;
    this.t = new Growing();
    this.xs = new Growing();
    this.ys = new Growing();
    this.headings = new Growing();
    this.clearance = new Curve();
    /** @type {Outline[]} pieces of the trail [m; world frame] */
    this.pieces = [];
    this.x = NaN;
    this.y = NaN;
    this.heading = 0;
    this.isMoving = false;
    this.place = -1;
  }

  /** @param {{t: number[], x: number[], y: number[], heading: number[]}} track */
  add(track) {
    this.t.pushDeltas(track.t, 1e-3);
    this.xs.pushDeltas(track.x, 1e-3);
    this.ys.pushDeltas(track.y, 1e-3);
    this.headings.pushDeltas(track.heading, 1e-3);
    while ((this.pieces.length + 1) * CHUNK < this.t.length) {
      const first = this.pieces.length * CHUNK;
      const piece = new Outline();
      piece.moveTo(this.xs.data[first], this.ys.data[first]);
      for (let i = first + 1; i <= first + CHUNK; i++) piece.lineTo(this.xs.data[i], this.ys.data[i]);
      this.pieces.push(piece);
    }
  }

  /** Put it where it is at a time. @param {number} t */
  goTo(t) {
    const i = placeAt(this.t.data, this.t.length, t);
    this.place = i;
    if (i < 0) {
      this.x = NaN;
      return;
    }
    const next = Math.min(i + 1, this.t.length - 1);
    const span = this.t.data[next] - this.t.data[i];
    const share = span > 0 ? (t - this.t.data[i]) / span : 0;
    const { xs, ys, headings } = this;
    this.x = xs.data[i] + share * (xs.data[next] - xs.data[i]);
    this.y = ys.data[i] + share * (ys.data[next] - ys.data[i]);
    this.heading = headings.data[i] + share * (headings.data[next] - headings.data[i]);
    const isLast = next === i && t - this.t.data[i] < UNTIL_SAMPLED_S;
    this.isMoving = this.movesFrom(i) || (isLast && i > 0 && this.movesFrom(i - 1));
  }

  /** Whether it drives or turns between a place and the next. @param {number} i */
  movesFrom(i) {
    const { xs, ys, headings } = this;
    if (i + 1 >= this.t.length) return false;
    return (
      xs.data[i] !== xs.data[i + 1] ||
      ys.data[i] !== ys.data[i + 1] ||
      headings.data[i] !== headings.data[i + 1]
    );
  }

  /** Stroke what it has driven by then. @param {CanvasRenderingContext2D} context */
  strokeTrail(context) {
    if (this.place < 0) return;
    const whole = Math.min(Math.floor(this.place / CHUNK), this.pieces.length);
    for (let piece = Math.max(whole - PIECES_SHOWN, 0); piece < whole; piece++)
      context.stroke(this.pieces[piece]);
    context.beginPath();
    context.moveTo(this.xs.data[whole * CHUNK], this.ys.data[whole * CHUNK]);
    for (let i = whole * CHUNK + 1; i <= this.place; i++) context.lineTo(this.xs.data[i], this.ys.data[i]);
    context.lineTo(this.x, this.y);
    context.stroke();
  }
}
