// The engine: sends requests to a worker, which runs the kernel, and returns the results.

export class Engine {
  #number = 0; // number of the newest request to the worker
  #waiting = new Map(); // number of a request → the functions for its result, its error and its progress
  #sceneSent; // a promise that is fulfilled when the worker has got the scene
  #fault; // the error with which the worker has ended, if any
  #ended = false;

  /** Start a worker with a `program`, a promise of its address. `compiled`: a promise of the compiled kernel, which all workers share. */
  constructor(program, compiled) {
    this.started = Promise.all([compiled, program.then((address) => this.#start(address))]);
  }

  #start(address) {
    this.worker = new Worker(address);
    this.worker.onmessage = ({ data }) => this.#receive(data);
    this.worker.onerror = ({ message }) => this.#fail(new Error(message || "the browser does not let it begin"));
  }

  /** Send a scene to the worker, which answers all later requests for this scene; return this engine. */
  open(scene) {
    this.#sceneSent = this.started.then(([module]) => this.worker.postMessage({ kind: "scene", scene, module }));
    return this;
  }

  /**
   * Send a request to the worker, and return its result; null if the worker was ended, or if the request has the option `replaces` and a
   * newer request of this `kind` has replaced it. `kind`: motion, pinned, rows or study (worker.js, also for `options`); `values`: the
   * changed parameters; `progress` is called with the fraction of the work that is done.
   */
  async ask(kind, values, options = {}, progress = () => {}) {
    await this.#sceneSent;
    if (this.#fault) throw this.#fault;
    if (this.#ended) return null;
    this.#number += 1;
    const number = this.#number;
    return new Promise((resolve, reject) => {
      this.#waiting.set(number, { resolve, reject, progress });
      this.worker.postMessage({ kind, number, values, options });
    });
  }

  /** End the worker; requests without an answer get the result null. */
  end() {
    this.#ended = true;
    this.started.then(() => this.worker.terminate(), () => {});
    this.#waiting.forEach(({ resolve }) => resolve(null));
  }

  #fail(error) {
    this.worker.terminate();
    this.#fault = error;
    this.#waiting.forEach(({ reject }) => reject(error));
    this.#waiting.clear();
  }

  #receive({ number, done, result, fault }) {
    const { resolve, reject, progress } = this.#waiting.get(number);
    if (done !== undefined) {
      progress(done);
      return;
    }
    this.#waiting.delete(number);
    if (fault) reject(new Error(fault));
    else resolve(result);
  }
}
