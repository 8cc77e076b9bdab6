// The kernel: the WebAssembly module with one instance in its memory, and its runs. `page_scene.js` has the indices of values in the
// instance's record.
// The twin in Python is `simulation/simulate.py`.

const { WORD } = SHARED.record; // [bytes] size of a word
const ROWS = 256; // largest number of rows of outputs that the kernel fills in one call, by default
const PAGE = 65536; // [bytes] size of a page of WebAssembly's memory

/** Return the first multiple of 64 bytes that is not below an address. */
function aligned(address) {
  return (address + 63) & ~63;
}

/** Return the times [s] of the rows of a result: multiples of the step from 0 on, below the stop time, and the stop time. */
export function rowTimes(stopTime, step) {
  const count = Math.ceil((stopTime / step) * (1 - SHARED.file.STEP_ROUND_OFF)) + 1;
  const times = Float64Array.from({ length: count }, (_, row) => row * step);
  times[count - 1] = stopTime;
  return times;
}

/**
 * Return the spans of consecutive words of the record that the outputs form: first word and number of words of each span, one after the
 * other in one list.
 */
function wordSpans(outputs) {
  const spans = [];
  for (const { word } of outputs) {
    const [first, count] = spans.at(-1) ?? [NaN, 0];
    if (word === first + count) spans.at(-1)[1] += 1;
    else spans.push([word, 1]);
  }
  return spans.flat().map(BigInt);
}

/** The mathematical functions that a user's law may call, taken from the browser. */
const mathematics = Object.assign(Object.create(Math), { fmod: (x, y) => x % y });

export class Kernel {
  /** Return a promise of the kernel of a module, for a scene in the form of `pageScene`. */
  static async load(module, scene) {
    const { exports } = await WebAssembly.instantiate(module, { Math: mathematics });
    return new Kernel(exports, scene, scene.record);
  }

  constructor(exports, scene, start) {
    this.exports = exports;
    this.scene = scene;
    this.start = start;
    this.record = aligned(exports.__heap_base.value);
    this.scratch = aligned(this.record + start.length);
    this.parameters = new Map(scene.parameters.map((parameter) => [parameter.name, parameter]));
    this.#reserve(this.scratch);
    this.bytes.set(start);
  }

  /** Make the memory reach to an address; only this function lets the memory grow, which makes all arrays over the memory invalid. */
  #reserve(end) {
    const { exports, start } = this;
    const missing = Math.ceil((end - exports.memory.buffer.byteLength) / PAGE);
    if (missing > 0) exports.memory.grow(missing);
    const { buffer } = exports.memory;
    this.bytes = new Uint8Array(buffer, this.record, start.length);
    this.reals = new Float64Array(buffer, this.record, start.length / WORD);
    this.integers = new BigInt64Array(buffer, this.record, start.length / WORD);
  }

  /** Return addresses after the record for arrays with the given numbers of words, and the address after the last array. */
  #allocate(sizes) {
    const addresses = sizes.reduce((all, size) => [...all, aligned(all.at(-1) + size * WORD)], [this.scratch]);
    this.#reserve(addresses.at(-1));
    return addresses;
  }

  get status() {
    return Number(this.integers[this.scene.layout.status]);
  }

  /** Write the scene's record, as it is before initialization, with the changes `values` of parameters: name → number. */
  #write(values) {
    this.bytes.set(this.start);
    for (const [name, value] of Object.entries(values)) {
      const { word, type } = this.parameters.get(name);
      if (word < 0) continue;
      if (type === "real") this.reals[word] = value;
      else this.integers[word] = BigInt(value);
    }
  }

  /** Write the scene's record with the changes `values` of parameters, name → number, and initialize it. */
  initialize(values) {
    this.#write(values);
    this.exports.initialize(this.record, 0);
  }

  /**
   * Run from the start of the scene through some times, and return the results. The generator yields the fraction that is done after each
   * call of the kernel for rows, so that its caller can do other work meanwhile.
   *
   * @param values the changed parameters: name → number.
   * @param times Float64Array [s].
   * @param outputs { word, integer } of the record, one for each column.
   * @param options `timesPerCall`: number of times in one call of the kernel, which cannot be interrupted. `inputSteps`: { time, word,
   * value } in the order of time: inputs that have another value from a time on.
   */
  *run(values, times, outputs = [], { timesPerCall = ROWS, inputSteps = [] } = {}) {
    const width = outputs.length;
    const spans = wordSpans(outputs);
    const [timesAt, spansAt, rowsAt] = this.#allocate([timesPerCall, spans.length, timesPerCall * width]);
    this.initialize(values);
    const columns = outputs.map(() => new Float64Array(times.length));
    const { buffer } = this.exports.memory;
    const givenTimes = new Float64Array(buffer, timesAt, timesPerCall);
    const reals = new Float64Array(buffer, rowsAt, timesPerCall * width);
    const integers = new BigInt64Array(buffer, rowsAt, timesPerCall * width);
    new BigInt64Array(buffer, spansAt, spans.length).set(spans);
    const impacts = [];
    let done = 0;
    for (const { time, word, value } of [...inputSteps, { time: Infinity }]) {
      const later = times.findIndex((other) => other > time);
      const until = later < 0 ? times.length : later;
      while (done < until && this.status === 0) {
        const count = Math.min(timesPerCall, until - done);
        givenTimes.set(times.subarray(done, done + count));
        const filled = Number(
          this.exports.trajectory(this.record, timesAt, BigInt(count), spansAt, BigInt(spans.length / 2), rowsAt, BigInt(width), 0));
        columns.forEach((column, k) => {
          const read = outputs[k].integer ? (from) => Number(integers[from]) : (from) => reals[from];
          for (let row = 0; row < filled; row += 1) column[done + row] = read(row * width + k);
        });
        done += filled;
        impacts.push(...this.#collectFinished());
        yield done / times.length;
      }
      if (this.status !== 0 || done === times.length) break;
      givenTimes[0] = time;
      let hasArrived = false;
      while (!hasArrived && this.status === 0) {
        hasArrived = this.exports.trajectory(this.record, timesAt, 1n, spansAt, 0n, rowsAt, 0n, 0) === 1n;
        impacts.push(...this.#collectFinished());
      }
      this.reals[word] = value;
      this.integers[this.scene.layout.pending] = BigInt(SHARED.kernel.REINITIALIZE);
    }
    const { status, reached } = { status: this.status, reached: this.reals[this.scene.layout.time] };
    const part = Number(this.integers[this.scene.layout.part]);
    const statistics = Object.fromEntries(
      Object.entries(this.scene.layout.statistics).map(([name, word]) => [name, Number(this.integers[word])]));
    if (status === 0 || done > 0) impacts.push(...this.#unfinished());
    const whole = (column) => (done === times.length ? column : column.slice(0, done));
    impacts.sort((a, b) => a.onset - b.onset || a.point - b.point || a.wall - b.wall);
    return {
      status,
      part,
      reached,
      statistics,
      impacts,
      time: whole(times),
      columns: columns.map(whole),
    };
  }

  /**
   * Run once for each row of values (`each`, one row after the other) of the real parameters `names`, up to the `endTime` [s], with the
   * other changes `values`. Return in `rows` the `words` of the record (indices) at the end of each run, one run after the other, and in
   * `firsts` the results of `firstOf` for the impacts and the changed parameters of each run. The generator yields when `run` does.
   */
  *runEach(values, names, each, endTime, words, firstOf = () => null) {
    const count = each.length / names.length;
    const rows = new BigInt64Array(count * words.length);
    const firsts = [];
    for (let number = 0; number < count; number += 1) {
      const given = Object.fromEntries(names.map((name, k) => [name, each[number * names.length + k]]));
      const changed = { ...values, ...given };
      const { impacts } = yield* this.run(changed, Float64Array.of(endTime), [], { timesPerCall: 1 });
      rows.set(words.map((word) => this.integers[word]), number * words.length);
      firsts.push(firstOf(impacts, changed));
    }
    return { rows: new Float64Array(rows.buffer), firsts };
  }

  /** Return the ended contacts that are new in the log; if the log is not read in time, its oldest contacts are lost. */
  #collectFinished() {
    const { contactLog, frictionChanges } = this.scene.layout;
    const ended = Number(this.integers[contactLog.count]);
    const first = Math.max(Number(this.integers[contactLog.collected]), ended - contactLog.capacity);
    this.integers[contactLog.collected] = this.integers[contactLog.count];
    this.integers[frictionChanges] = 0n;
    return this.#contactsInLog(ended - first, (index) => (first + index) % contactLog.capacity);
  }

  /** Return `count` contacts of the log; contact k, from 0, is in row `rowOf(k)` of the log. */
  #contactsInLog(count, rowOf) {
    const { reals, integers, scene: { layout: { contactLog, impulses, loads } } } = this;
    const unknown = { ...(integers[impulses] === 0n && { impulse: NaN }), ...(integers[loads] === 0n && { joint_force: NaN }) };
    return Array.from({ length: count }, (_, index) => {
      const row = rowOf(index);
      const read = ([name, word]) =>
        [name, SHARED.contactLog.REALS.includes(name) ? reals[word + row] : Number(integers[word + row])];
      return { ...Object.fromEntries(Object.entries(contactLog.fields).map(read)), ...unknown };
    });
  }

  /**
   * Return the contacts that still last, with the values so far. The call changes the record: the kernel cuts its last step at the present
   * time, and writes these contacts into the log after the ended ones, where they do not count as ended. So the call is made only at the
   * end of a run.
   */
  #unfinished() {
    this.exports.log_contacts(this.record);
    const { contactLog, active } = this.scene.layout;
    const ended = Number(this.integers[contactLog.count]);
    return this.#contactsInLog(Number(this.integers[active]), (index) => (ended + index) % contactLog.capacity);
  }
}

/** Run a generator to its end, and return its result. */
export function runThrough(run) {
  let step = run.next();
  while (!step.done) step = run.next();
  return step.value;
}
