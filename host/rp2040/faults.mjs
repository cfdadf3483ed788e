// What goes wrong on the bench.
const DMA_IRQ_0 = 1 << 11;

/** Wakes the core for what is pending. */
function look(core) {
  core.interruptsUpdated = true;
  if (core.waiting && core.checkForInterrupts()) core.waiting = false;
}

export const faults = {
  /** The interrupt of the channels is held for so long. */
  late(mcu, nanos) {
    const { core, clock } = mcu;
    core.enabledInterrupts &= ~DMA_IRQ_0;
    clock
      .createAlarm(() => {
        core.enabledInterrupts |= DMA_IRQ_0;
        look(core);
      })
      .schedule(nanos);
  },
  /** The interrupt comes though nothing has ended, as soon as the core takes it. */
  doubled(mcu) {
    const { core, clock } = mcu;
    core.pendingInterrupts |= DMA_IRQ_0;
    core.interruptsUpdated = true;
    const entered = core.checkForInterrupts();
    if (entered) core.waiting = false;
    core.pendingInterrupts &= ~DMA_IRQ_0;
    // The handler of the eleventh line.
    if (!entered || core.IPSR !== 16 + 11) clock.createAlarm(() => faults.doubled(mcu)).schedule(1e3);
  },
  /** The next flags of the channels are lost, with their interrupt. */
  lost(mcu) {
    const { dma } = mcu;
    const check = dma.checkInterrupts.bind(dma);
    dma.checkInterrupts = () => {
      if (dma.intRaw & 3) {
        dma.intRaw &= ~3;
        dma.checkInterrupts = check;
      }
      check();
    };
  },
  /** The channels are not asked for so long: the converter's queue runs over after four samples. */
  overrun(mcu, nanos) {
    const { adc, clock, dma } = mcu;
    const update = adc.updateDMA;
    adc.updateDMA = () => dma.clearDREQ(36);
    adc.updateDMA();
    clock
      .createAlarm(() => {
        adc.updateDMA = update;
        adc.updateDMA();
      })
      .schedule(nanos);
  },
  /** A transfer fails: the channel stands, with its flag. */
  error(mcu) {
    const channel = mcu.dma.channels.slice(0, 2).find((channel) => channel.active);
    if (!channel) return;
    channel.abort();
    // AHB_ERROR 31, READ_ERROR 30.
    channel.ctrl |= (3 << 30) | 0;
    mcu.dma.intRaw |= 1 << channel.index;
    mcu.dma.checkInterrupts();
  },
};
