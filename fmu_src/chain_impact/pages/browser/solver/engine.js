// The engine: the part of the page that sends requests to a worker.

export class Engine {
  #number = 0; // number of the newest request to the worker
  #waiting = new Map(); // table from the number of a request to the functions for its result, its error and its progress
  #sceneSent; // a promise that is fulfilled when the scene has been sent to the worker
  #fault; // the error with which the worker has ended, if any
  #ended = false;

  /** Start a worker that runs the program at an address; `compiled` is a promise of the compiled kernel, which all workers share. */
  constructor(address, compiled) {
    this.compiled = compiled;
    this.worker = new Worker(address);
    this.worker.onmessage = ({ data }) => this.#receive(data);
    this.worker.onerror = ({ message }) => this.#fail(new Error(message || "the browser does not let it begin"));
  }

  /** Let the worker answer requests for a scene; return this engine. */
  open(scene) {
    this.#sceneSent = this.compiled.then((module) => this.worker.postMessage({ kind: "scene", scene, module }));
    return this;
  }

  /**
   * Return the result of a request; null if a newer request has replaced it, or the worker has ended. `progress` is called
   * with the finished fraction.
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

  /** End the worker; requests that are not answered get no result. */
  end() {
    this.#ended = true;
    this.worker.terminate();
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
