// What became of the messages of each link: taken by faults as time goes on, and the books that robots close with.

/**
 * @typedef {{sender: number, receiver: number, sent: number | null, received: number | null, injected: number}} Book
 *   null: who counts it never told all
 */

class Losses {
  constructor() {
    /** @type {Map<string, Curve>} how many a fault plan has taken or damaged, by link */
    this.taken = new Map();
    /** @type {Book[]} */
    this.books = [];
  }

  /** @param {{t: number[], sender: number[], receiver: number[]}} taken */
  take({ t, sender, receiver }) {
    let ms = 0;
    t.forEach((delta, i) => {
      ms += delta;
      const link = `${sender[i]} > ${receiver[i]}`;
      let curve = this.taken.get(link);
      if (!curve) this.taken.set(link, (curve = new Curve()));
      curve.push(ms / 1e3, (curve.value.length ? curve.value.last : 0) + 1);
    });
  }
}
