// What runs beside the microphone: it hands on each chunk of samples.
registerProcessor("chunks", class extends AudioWorkletProcessor {
  process([[channel]]) {
    if (channel) this.port.postMessage(channel.slice());
    return true;
  }
});
