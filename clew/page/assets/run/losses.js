// What became of the messages of each link: taken by faults as time goes on, and the books that robots close with.

/**
 * @typedef {{sent: number, received: number, injected: number}} Book
 * @typedef {{sent: number | null, received: number | null, injected: number}} Told null: who counts it never told all
 */

class Losses {
  constructor() {
    /** @type {Map<string, Curve>} how many a fault plan has taken or damaged, by link */
    this.taken = new Map();
    /** @type {Map<string, Book>} by link, `1 > 2` */
    this.books = new Map();
    /** @type {Record<"settled" | "counted" | "restarted", Set<number>>} robots that told what they sent, and received */
    this.who = { settled: new Set(), counted: new Set(), restarted: new Set() };
    this.others = 0;
  }

  /** @param {string} kind @param {Columns} rows @param {number} i */
  add(kind, rows, i) {
    if (kind === "fault.injected" && rows.key[i]) this.take(rows.t[i], rows.key[i], rows.fault[i]);
    if (kind === "robot.restarted") this.who.restarted.add(rows.robot[i]);
    if (kind === "robot.settled") {
      this.who.settled.add(robotOf(rows.source[i]));
      this.settle(rows.sent[i]);
    }
    if (kind === "traffic.counted") {
      this.who.counted.add(robotOf(rows.source[i]));
      this.count(rows.received[i], rows.injected[i]);
    }
  }

  /** @param {number} t @param {string} key @param {string} fault */
  take(t, key, fault) {
    if (fault === "delay" || fault === "duplicate" || fault === "reorder") return; // late or twice, but not lost
    const link = linkOf(key);
    if (link === null) {
      this.others++;
      return;
    }
    let curve = this.taken.get(link);
    if (!curve) this.taken.set(link, (curve = new Curve()));
    curve.push(t, (curve.value.length ? curve.value.last : 0) + 1);
  }

  /** @param {Record<string, number>} sent */
  settle(sent) {
    for (const [key, count] of Object.entries(sent)) {
      const link = linkOf(key);
      if (link !== null) this.book(link).sent = count;
    }
  }

  /** @param {Record<string, number>} received @param {Record<string, Record<string, number>>} injected */
  count(received, injected) {
    for (const [key, count] of Object.entries(received)) {
      const link = linkOf(key);
      if (link !== null) this.book(link).received = count;
    }
    for (const byKey of Object.values(injected)) {
      for (const [key, count] of Object.entries(byKey)) {
        const link = linkOf(key);
        if (link !== null) this.book(link).injected += count;
      }
    }
  }

  /**
   * All books, by link. Who was started again counted in its last life only, and its neighbours in all of its lives.
   * @returns {[string, Told][]}
   */
  told() {
    const { settled, counted, restarted } = this.who;
    return [...this.books].map(([link, book]) => {
      const [sender, receiver] = link.split(" > ").map(Number);
      const sent = settled.has(sender) && !restarted.has(sender) ? book.sent : null;
      const received = counted.has(receiver) && !restarted.has(receiver) ? book.received : null;
      return [link, { sent, received, injected: book.injected }];
    });
  }

  /** @param {string} link @returns {Book} */
  book(link) {
    let book = this.books.get(link);
    if (!book) this.books.set(link, (book = { sent: 0, received: 0, injected: 0 }));
    return book;
  }
}

/** @param {string} key without the run's root @returns {string | null} null: no link's */
function linkOf(key) {
  const [kind, sender, receiver] = key.split("/");
  return kind === "link" ? `${robotOf(sender)} > ${robotOf(receiver)}` : null;
}
