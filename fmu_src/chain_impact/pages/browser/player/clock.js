// The clock of the player: the frame on the screen, and the rate at which simulated time passes.

export const SPEEDS = [1 / 16, 1 / 8, 1 / 4, 1 / 2, 1, 2, 4];
const STEP = 1 / 30; // [s] time on the screen by which one press of an arrow key moves the motion

/** The clock. Its method `set` changes its properties, and calls its listeners. */
export class Clock {
  #listeners = [];
  // the impact to which the reader has gone, until the time changes; the time alone would not tell which impact, because several may have
  // the same onset
  #goneTo = null;

  constructor(speed) {
    this.speed = speed;
    this.frame = 0;
    this.playing = false;
    this.slow = true;
    this.loop = false;
  }

  /**
   * Use another recording. The simulated time stays or, if the recording does not reach it, becomes the nearest time. An impact to which
   * the reader has gone stays the present one if the recording has it, too.
   */
  show(recording) {
    const [time, chosen] = [this.recording ? this.time : recording.start, this.#goneTo];
    this.recording = recording;
    this.seek(time);
    this.#goneTo = recording.impacts.find(({ number, onset }) => number === chosen?.number && onset === chosen.onset) ?? null;
    if (this.#goneTo) this.set({});
  }

  onChange(listener) {
    this.#listeners.push(listener);
  }

  get time() {
    return this.recording.timeAt(this.frame);
  }

  /** Return the contact that list, chart and caption describe; undefined if the recording has none. */
  get contact() {
    return this.#goneTo ?? this.recording.contactAt(this.time);
  }

  get last() {
    return this.recording.time.length - 1;
  }

  /** Return whether the motion is paused at the end of the recording. */
  get hasEnded() {
    return !this.playing && this.frame >= this.last;
  }

  /** Return the simulated seconds per second on the screen. */
  get rate() {
    return this.speed * (this.slow ? this.recording.rateAt(this.frame) : 1);
  }

  /** Return the time that the whole motion takes on the screen [s]. */
  get duration() {
    const { start, end, frameRate } = this.recording;
    return (this.slow ? this.last / frameRate : end - start) / this.speed;
  }

  /** Change any of the properties frame, playing, slow, loop and speed, and call the listeners. Without a recording, nothing changes. */
  set(changes) {
    if (!this.recording) return;
    Object.assign(this, changes);
    if ("frame" in changes) this.#goneTo = null;
    this.frame = Math.min(Math.max(this.frame, 0), this.last);
    this.#listeners.forEach((listener) => listener());
  }

  /** Go to a time [s]; a given `contact` becomes the present one, until the time changes. */
  seek(time, contact = null) {
    this.set({ frame: this.recording.frameAt(time) });
    this.#goneTo = contact;
    if (contact) this.set({});
  }

  /** Play or pause; at the end of the recording, play from the start. */
  toggle() {
    const again = this.hasEnded;
    this.set({ playing: !this.playing, frame: again ? 0 : this.frame });
  }

  /** Move the frame ahead by a time on the screen [s], or back if this time is < 0; loop or pause at the end of the recording. */
  advance(seconds) {
    const frame = this.slow
      ? this.frame + seconds * this.speed * this.recording.frameRate
      : this.recording.frameAt(this.time + seconds * this.speed);
    const again = this.loop && this.playing && frame >= this.last;
    this.set({ frame: again ? 0 : frame, playing: this.playing && (again || frame < this.last) });
  }

  /** Pause, and move back (−1) or ahead (1) by STEP seconds on the screen. */
  step(direction) {
    this.playing = false;
    this.advance(direction * STEP);
  }

  /** Choose the next faster (1) or slower (−1) speed of SPEEDS. */
  shift(direction) {
    const faster = SPEEDS.filter((speed) => (speed - this.speed) * direction > 1e-9);
    if (faster.length) this.set({ speed: direction > 0 ? faster[0] : faster[faster.length - 1] });
  }

  /** Go to the time of an impact's largest force, or to its onset if this force is unknown, as at a rigid wall. */
  toImpact(impact) {
    this.seek(impact.peakTime);
    // round-off could give a frame just before the onset, where the contact is not shown
    while (this.time < impact.onset) this.frame += 1e-3;
    this.#goneTo = impact;
    this.set({});
  }

  /**
   * Go to the nearest time before (−1) or after (1) the present one at which an impact has its largest force (`peakTime`). If there is none
   * before, go to the start; if there is none after, stay.
   */
  stepImpact(direction) {
    const now = this.time;
    const same = 1e-9 * (1 + Math.abs(now)) + 2e-3 * this.recording.rateAt(this.frame) / this.recording.frameRate;
    const ahead = ({ peakTime }) => direction * (peakTime - now);
    // all impacts are searched, because an impact with an earlier onset may have its largest force later
    const nearest = this.recording.impacts.filter((impact) => ahead(impact) > same)
      .reduce((best, impact) => (best && ahead(best) <= ahead(impact) ? best : impact), null);
    if (nearest) this.toImpact(nearest);
    else if (direction < 0) this.seek(this.recording.start);
  }
}
