// SPDX-License-Identifier: GPL-3.0-or-later
// The WebSocket to the bridge: connects, reconnects, hands messages on.

import { decode_frame } from "./layout.js";

const kProtocol = "hapticd.view.v1";
const kFirstPause = 100; // [ms] before the first new attempt; doubled each time
const kLongestPause = 1000;
const kTokenKey = "hapticd.token";

/** The token of the address (#token=… or #…), taken out of the address bar; else the tab's own. */
export function take_token() {
  const fragment = decodeURIComponent(location.hash.replace(/^#(token=)?/, ""));
  if (fragment) {
    history.replaceState(null, "", location.pathname + location.search);
    try {
      sessionStorage.setItem(kTokenKey, fragment);
    } catch {
      /* storage may be off: then it is kept in memory */
    }
    return fragment;
  }
  try {
    return sessionStorage.getItem(kTokenKey);
  } catch {
    return null;
  }
}

/**
 * `on` has a function for each type of text message, and frame(frame), opened(), closed(),
 * trouble(text). `stats` counts. Messages are handed on in order, from the layout onwards.
 */
export class Connection {
  constructor(token, on, stats) {
    this.token = token;
    this.on = on;
    this.stats = stats;
    this.pause = kFirstPause;
    this.layout = null;
    this.next_id = 1;
    this.answers = new Map();
    this.open();
  }

  async open() {
    try {
      const reply = await fetch("/layout.json", { cache: "no-store" });
      if (!reply.ok) throw new Error(`layout.json: ${reply.status}`);
      this.layout = await reply.json();
    } catch {
      return this.again();
    }
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/view`, kProtocol);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.opened(socket);
    socket.onmessage = ({ data }) => this.receive(data);
    socket.onclose = () => this.closed();
    return undefined;
  }

  opened(socket) {
    this.socket = socket;
    this.pause = kFirstPause;
    this.last_sequence = null;
    if (this.token) this.send({ type: "token", token: this.token });
    this.on.opened();
  }

  closed() {
    const was_open = this.socket !== undefined;
    this.socket = undefined;
    for (const settle of this.answers.values()) {
      settle({ ok: false, text: "The bridge went away before it answered." });
    }
    this.answers.clear();
    if (was_open) {
      this.stats.reconnects += 1;
      this.on.closed();
    }
    this.again();
  }

  again() {
    setTimeout(() => this.open(), this.pause);
    this.pause = Math.min(2 * this.pause, kLongestPause);
  }

  receive(data) {
    this.on.heard();
    try {
      if (typeof data !== "string") return this.receive_frame(data);
      const message = JSON.parse(data);
      if (message.type === "answer") return this.answered(message);
      return this.on[message.type]?.(message);
    } catch (error) {
      this.stats.errors += 1;
      console.error(error);
      this.on.trouble(`A message of the bridge could not be used: ${error.message}`);
    }
    return undefined;
  }

  receive_frame(data) {
    const frame = decode_frame(data, this.layout);
    this.stats.frames_received += 1;
    if (this.last_sequence !== null && frame.sequence > this.last_sequence + 1) {
      this.stats.sequence_gaps += frame.sequence - this.last_sequence - 1;
    }
    this.last_sequence = frame.sequence;
    this.on.frame(frame);
  }

  answered({ id, ok, text }) {
    this.answers.get(id)?.({ ok, text });
    this.answers.delete(id);
  }

  send(message) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /** Sends a line for the control socket; gives {ok, text}. */
  command(line) {
    const id = this.next_id;
    this.next_id += 1;
    return new Promise((settle) => {
      this.answers.set(id, settle);
      if (!this.send({ type: "command", id, line })) {
        this.answers.delete(id);
        settle({ ok: false, text: "Not connected to the bridge." });
      }
    });
  }
}
