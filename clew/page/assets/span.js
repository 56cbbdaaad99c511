// The part of a run's time that the lanes and the charts show: one for all of them.

const SPAN_S_MIN = 0.2; // poses are sampled every 0.1 s: there is nothing to see between two

class Span {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.from = 0;
    this.until = Infinity; // the end, of a run that goes on too
    /** @type {{from: number, to: number} | null} what is being picked with the pointer */
    this.picked = null;
  }

  get to() {
    return Math.max(Math.min(this.until, this.app.end), this.from + 1e-3);
  }

  get isWhole() {
    return this.from <= 0 && this.until >= this.app.end;
  }

  /** How far a time is from the left to the right. @param {number} t */
  share(t) {
    const known = Math.min(t, this.app.end || t); // a run that goes on is ahead of its axis
    return (known - this.from) / (this.to - this.from);
  }

  /** @param {number} share */
  timeAt(share) {
    return this.from + Math.min(Math.max(share, 0), 1) * (this.to - this.from);
  }

  /** @param {number} from @param {number} to */
  show(from, to) {
    const length = Math.min(Math.max(to - from, SPAN_S_MIN), this.app.end);
    this.from = Math.min(Math.max(from, 0), this.app.end - length);
    this.until = length < this.app.end ? this.from + length : Infinity;
    this.app.show();
  }

  whole() {
    this.show(0, Infinity);
  }

  /** @param {number} factor above 1: less time, seen larger @param {number} t what stays in its place */
  zoom(factor, t) {
    const length = (this.to - this.from) / factor;
    const from = t - this.share(t) * length;
    this.show(from, from + Math.max(length, SPAN_S_MIN));
  }

  /** @param {number} by its own length */
  pan(by) {
    const length = this.to - this.from;
    if (!this.isWhole) this.show(this.from + by * length, this.to + by * length);
  }

  /** Have a time in view: as one turns a page. @param {number} t */
  keep(t) {
    const length = this.to - this.from;
    if (this.isWhole || (t >= this.from && t <= this.to)) return;
    this.show(t - (t > this.to ? 0.1 : 0.9) * length, t + (t > this.to ? 0.9 : 0.1) * length);
  }
}
