// SPDX-License-Identifier: GPL-2.0-or-later
/*
 * A PCI-1716 without the card, for the tests: the driver and board name, subdevices, channels, ranges and resolution
 * that the out-of-tree adv_pci1710 driver gives, on the kernel's own comedi core. Analog output 0 is wired to analog
 * input 0, output 1 to input 2 (so that the differential pairs read the same); the odd inputs are grounded.
 *
 * With rod=1 analog input 0 is the displacement sensor of a rod behind a valve at output 0: while digital output 0 is on
 * (the hydraulics), it moves by 0.14 in/(V s) of what exceeds the valve's dead band of 0.25 V, between end stops at 0 and
 * 5.9 in, which read as -10 and 10 V. It begins at 2.95 in. rod_uV is where it truly is, as a sound sensor would read;
 * written, it moves the rod there, as a hand does while the hydraulics are off.
 *
 * Like the real driver, attach and detach put the outputs to code 0 of 0..5 V and all digital outputs off, and a
 * change of range shows the old code in the new range until the new code is written: both steps are in the log.
 *
 * Faults, in /sys/module/pci1716_card/parameters. A count is how many more conversions it spoils, -1 all to come:
 *   ai_timeout (count), ai_timeout_ms    the conversion ends with ETIME, after that long
 *   ai_io_error (count)                  the conversion ends with EIO
 *   ai_stall (count), ai_stall_ms        the conversion takes that much longer
 *   ai_stuck (0 or 1)                    every channel keeps the code of its last good conversion
 *   ai_noise (steps)                     noise of up to that many steps either way on every conversion, a stuck one's too
 *   ai_open (0 or 1), ai_open_mV         the wire of input 0 is off: it reads that voltage
 *   ai_slope_percent                     slope of the sensor at input 0 about 0 V; -100 is the wrong sign
 *   ao_timeout (count), ao_timeout_ms    the write to the output ends with ETIME, after that long, and writes nothing
 *   contact                              0: none; digital input 1 shows the enable contactor, 1: as digital output 0 is,
 *                                        2: always open, 3: always closed
 *   all_ones (0 or 1)                    analog and digital inputs read all ones, as a card that left its bus does
 *   removed (0 or 1)                     the device goes, as by a hot unplug; 0 brings it back
 *   di                                   word at the digital inputs (an emergency stop is one of its bits)
 *
 * /proc/pci1716_wire: what stands on the wire. /proc/pci1716_changes: the newest changes, oldest first:
 *   CLOCK_MONOTONIC_ns ao0|ao1|do value_uV|word
 */
#include <linux/comedi/comedidev.h>
#include <linux/delay.h>
#include <linux/math64.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/proc_fs.h>
#include <linux/sched.h>
#include <linux/seq_file.h>
#include <linux/timekeeping.h>

enum { AI_CHANNELS = 16, AO_CHANNELS = 2, DIO_LINES = 16, MAX_CODE = 0xffff, AO_RESET_RANGE = 2, LOG_LENGTH = 4096 };

static int ai_timeout, ai_timeout_ms, ai_io_error, ai_stall, ai_stall_ms, ai_stuck, all_ones;
static int ai_noise, ai_open, ai_open_mV, ai_slope_percent = 100, ao_timeout, ao_timeout_ms, contact;
static int rod, rod_uV;
static s64 rod_nV;
static uint di = 0xffff;
module_param(ai_noise, int, 0644);
module_param(ai_open, int, 0644);
module_param(ai_open_mV, int, 0644);
module_param(ai_slope_percent, int, 0644);
module_param(ao_timeout, int, 0644);
module_param(ao_timeout_ms, int, 0644);
module_param(contact, int, 0644);
module_param(rod, int, 0444);
module_param(ai_timeout, int, 0644);
module_param(ai_timeout_ms, int, 0644);
module_param(ai_io_error, int, 0644);
module_param(ai_stall, int, 0644);
module_param(ai_stall_ms, int, 0644);
module_param(ai_stuck, int, 0644);
module_param(all_ones, int, 0644);
module_param(di, uint, 0644);

static const struct comedi_lrange ai_ranges = {
	9, { BIP_RANGE(5), BIP_RANGE(2.5), BIP_RANGE(1.25), BIP_RANGE(0.625), BIP_RANGE(10),
	     UNI_RANGE(10), UNI_RANGE(5), UNI_RANGE(2.5), UNI_RANGE(1.25) }
};
static const struct comedi_lrange ao_ranges = {
	6, { BIP_RANGE(5), BIP_RANGE(10), UNI_RANGE(5), UNI_RANGE(10), RANGE_ext(-1, 1), RANGE_ext(0, 1) }
};

enum wire { WIRE_AO0, WIRE_AO1, WIRE_DO };
static const char *const wire_names[] = { "ao0", "ao1", "do" };

struct wire_change {
	u64 time_ns;
	enum wire wire;
	s32 value; /* uV, or the digital word */
};

/* One card, so its state is the module's; the comedi core's mutex guards it, the log has its own lock for readers. */
static struct {
	unsigned int code, range;
} ao[AO_CHANNELS];
static unsigned int last_good[AI_CHANNELS] = { [0 ... AI_CHANNELS - 1] = 0x8000 };
static unsigned int do_word;
static DEFINE_SPINLOCK(log_lock);
static struct wire_change wire_log[LOG_LENGTH];
static u64 log_count;

static void log_change(enum wire wire, s32 value)
{
	struct wire_change *entry;

	spin_lock(&log_lock);
	entry = &wire_log[log_count++ % LOG_LENGTH];
	entry->time_ns = ktime_get_ns();
	entry->wire = wire;
	entry->value = value;
	spin_unlock(&log_lock);
}

static s64 code_to_nV(const struct comedi_krange *range, unsigned int code)
{
	s64 span_uV = (s64)range->max - range->min;

	return range->min * 1000LL + div_s64(span_uV * 1000 * code, MAX_CODE);
}

static unsigned int nV_to_code(const struct comedi_krange *range, s64 nV)
{
	s64 span_nV = ((s64)range->max - range->min) * 1000;
	s64 above_nV = nV - range->min * 1000LL;

	if (above_nV <= 0)
		return 0;
	if (above_nV >= span_nV)
		return MAX_CODE;
	return div64_s64(above_nV * MAX_CODE + span_nV / 2, span_nV);
}

static s64 ao_nV(unsigned int channel)
{
	return code_to_nV(&ao_ranges.range[ao[channel].range], ao[channel].code);
}

static void log_ao(unsigned int channel)
{
	log_change(channel ? WIRE_AO1 : WIRE_AO0, (s32)div_s64(ao_nV(channel), 1000));
}

/* Whether a fault with this many conversions to go strikes now. */
static bool strikes(int *count)
{
	if (*count > 0)
		(*count)--;
	else if (*count == 0)
		return false;
	return true;
}

static void take_longer(int duration_ms)
{
	if (duration_ms > 0)
		usleep_range(duration_ms * 1000, duration_ms * 1000 + 50);
}

enum { ROD_DEAD_BAND_uV = 250000, ROD_END_uV = 10000000, ENABLE_BIT = 1 };

/* Moves the rod to now. Before every reading, and before anything that changes its speed. */
static void move_rod(void)
{
	static u64 last_us;
	u64 now_us = div_u64(ktime_get_ns(), 1000);
	s64 command_uV = div_s64(ao_nV(0), 1000);
	s64 passed_us = min_t(u64, now_us - last_us, 1000000);

	last_us = now_us;
	if (!(do_word & ENABLE_BIT))
		return;
	if (command_uV > ROD_DEAD_BAND_uV)
		command_uV -= ROD_DEAD_BAND_uV;
	else if (command_uV < -ROD_DEAD_BAND_uV)
		command_uV += ROD_DEAD_BAND_uV;
	else
		return;
	/* 0.14 in/(V s) at 0.295 in/V of the sensor: 0.4746 V/s a volt */
	rod_nV += div_s64(command_uV * passed_us * 4746, 10000000);
	rod_nV = clamp_t(s64, rod_nV, -ROD_END_uV * 1000LL, ROD_END_uV * 1000LL);
	rod_uV = (int)div_s64(rod_nV, 1000);
}

static int place_rod(const char *text, const struct kernel_param *parameter)
{
	int status = param_set_int(text, parameter);

	if (!status)
		rod_nV = rod_uV * 1000LL;
	return status;
}

static const struct kernel_param_ops rod_ops = { .set = place_rod, .get = param_get_int };
module_param_cb(rod_uV, &rod_ops, &rod_uV, 0644);

static s64 sensor_nV(void)
{
	if (ai_open)
		return ai_open_mV * 1000000LL;
	move_rod();
	return rod_uV * 10LL * ai_slope_percent;
}

static s64 input_nV(unsigned int channel)
{
	if (channel == 0 && rod)
		return sensor_nV();
	if (channel == 0)
		return ao_nV(0);
	if (channel == 2)
		return ao_nV(1);
	return 0;
}

static unsigned int with_noise(unsigned int code)
{
	static u32 state = 1;
	int noise = 0;

	if (ai_noise > 0) {
		state = state * 1664525u + 1013904223u; /* Numerical Recipes' generator: any run is like any other */
		noise = (int)((state >> 8) % (2 * ai_noise + 1)) - ai_noise;
	}
	return (unsigned int)clamp_t(int, (int)code + noise, 0, MAX_CODE);
}

static int ai_read(struct comedi_device *dev, struct comedi_subdevice *s, struct comedi_insn *insn, unsigned int *data)
{
	unsigned int channel = CR_CHAN(insn->chanspec);
	unsigned int i;

	for (i = 0; i < insn->n; i++) {
		if (strikes(&ai_stall))
			take_longer(ai_stall_ms);
		if (strikes(&ai_timeout)) {
			take_longer(ai_timeout_ms);
			return -ETIME;
		}
		if (strikes(&ai_io_error))
			return -EIO;
		if (!ai_stuck)
			last_good[channel] = nV_to_code(&ai_ranges.range[CR_RANGE(insn->chanspec)], input_nV(channel));
		data[i] = all_ones ? MAX_CODE : with_noise(last_good[channel]);
	}
	return insn->n;
}

static int ao_write(struct comedi_device *dev, struct comedi_subdevice *s, struct comedi_insn *insn, unsigned int *data)
{
	unsigned int channel = CR_CHAN(insn->chanspec);
	unsigned int range = CR_RANGE(insn->chanspec);
	unsigned int i;

	move_rod();
	if (strikes(&ao_timeout)) {
		take_longer(ao_timeout_ms);
		return -ETIME;
	}
	if (range != ao[channel].range) {
		ao[channel].range = range;
		log_ao(channel);
	}
	for (i = 0; i < insn->n; i++) {
		ao[channel].code = data[i];
		log_ao(channel);
	}
	return insn->n;
}

static int ao_read(struct comedi_device *dev, struct comedi_subdevice *s, struct comedi_insn *insn, unsigned int *data)
{
	unsigned int i;

	for (i = 0; i < insn->n; i++)
		data[i] = ao[CR_CHAN(insn->chanspec)].code;
	return insn->n;
}

static int di_bits(struct comedi_device *dev, struct comedi_subdevice *s, struct comedi_insn *insn, unsigned int *data)
{
	unsigned int word = di & 0xffff;

	if (contact) {
		bool closed = contact == 3 || (contact == 1 && (do_word & ENABLE_BIT));

		word = closed ? word | 2 : word & ~2u;
	}
	data[1] = all_ones ? 0xffff : word;
	return insn->n;
}

static int do_bits(struct comedi_device *dev, struct comedi_subdevice *s, struct comedi_insn *insn, unsigned int *data)
{
	move_rod();
	if (comedi_dio_update_state(s, data)) {
		do_word = s->state;
		log_change(WIRE_DO, do_word);
	}
	data[1] = s->state;
	return insn->n;
}

static void reset_outputs(void)
{
	unsigned int channel;

	for (channel = 0; channel < AO_CHANNELS; channel++) {
		ao[channel].range = AO_RESET_RANGE;
		ao[channel].code = 0;
		log_ao(channel);
	}
	do_word = 0;
	log_change(WIRE_DO, 0);
}

static void set_up(struct comedi_subdevice *s, int type, int flags, int channels, unsigned int maxdata,
		   const struct comedi_lrange *ranges)
{
	s->type = type;
	s->subdev_flags = flags | SDF_GROUND | SDF_COMMON;
	s->n_chan = channels;
	s->maxdata = maxdata;
	s->range_table = ranges;
}

static int card_auto_attach(struct comedi_device *dev, unsigned long context)
{
	struct comedi_subdevice *s;
	int status;

	dev->board_name = "pci1716";
	status = comedi_alloc_subdevices(dev, 4);
	if (status)
		return status;

	s = &dev->subdevices[0];
	set_up(s, COMEDI_SUBD_AI, SDF_READABLE | SDF_DIFF, AI_CHANNELS, MAX_CODE, &ai_ranges);
	s->insn_read = ai_read;

	s = &dev->subdevices[1];
	set_up(s, COMEDI_SUBD_AO, SDF_WRITABLE, AO_CHANNELS, MAX_CODE, &ao_ranges);
	s->insn_write = ao_write;
	s->insn_read = ao_read;

	s = &dev->subdevices[2];
	set_up(s, COMEDI_SUBD_DI, SDF_READABLE, DIO_LINES, 1, &range_digital);
	s->insn_bits = di_bits;

	s = &dev->subdevices[3];
	set_up(s, COMEDI_SUBD_DO, SDF_WRITABLE, DIO_LINES, 1, &range_digital);
	s->io_bits = 0xffff;
	s->insn_bits = do_bits;

	reset_outputs();
	return 0;
}

static void card_detach(struct comedi_device *dev)
{
	reset_outputs();
}

static struct comedi_driver card_driver = {
	.driver_name = "adv_pci1710",
	.module = THIS_MODULE,
	.auto_attach = card_auto_attach,
	.detach = card_detach,
};

static struct platform_device *card;
static bool removed;

static int set_removed(const char *text, const struct kernel_param *parameter)
{
	bool was = removed;
	int status = param_set_bool(text, parameter);

	if (status || removed == was || !card)
		return status;
	if (!removed)
		return comedi_auto_config(&card->dev, &card_driver, 0);
	comedi_auto_unconfig(&card->dev);
	return 0;
}

static const struct kernel_param_ops removed_ops = { .set = set_removed, .get = param_get_bool };
module_param_cb(removed, &removed_ops, &removed, 0644);

static int show_wire(struct seq_file *file, void *unused)
{
	seq_printf(file, "ao0 %lld\nao1 %lld\ndo %u\n", div_s64(ao_nV(0), 1000), div_s64(ao_nV(1), 1000), do_word);
	return 0;
}

/* The changes that one reader sees: those there when it began. */
struct reading {
	u64 first;
	u64 end;
};

static void *change_at(struct seq_file *file, loff_t *position)
{
	struct reading *reading = file->private;

	return reading->first + *position < reading->end ? position : NULL;
}

static void *first_change(struct seq_file *file, loff_t *position)
{
	struct reading *reading = file->private;

	if (*position == 0) {
		spin_lock(&log_lock);
		reading->end = log_count;
		spin_unlock(&log_lock);
		reading->first = reading->end > LOG_LENGTH ? reading->end - LOG_LENGTH : 0;
	}
	return change_at(file, position);
}

static void *next_change(struct seq_file *file, void *unused, loff_t *position)
{
	++*position;
	return change_at(file, position);
}

static void no_more_changes(struct seq_file *file, void *unused)
{
}

static int show_change(struct seq_file *file, void *position)
{
	struct reading *reading = file->private;
	struct wire_change entry;

	spin_lock(&log_lock);
	entry = wire_log[(reading->first + *(loff_t *)position) % LOG_LENGTH];
	spin_unlock(&log_lock);
	seq_printf(file, "%llu %s %d\n", entry.time_ns, wire_names[entry.wire], entry.value);
	return 0;
}

static const struct seq_operations change_ops = {
	.start = first_change, .next = next_change, .stop = no_more_changes, .show = show_change,
};

static void remove_proc_entries(void)
{
	remove_proc_entry("pci1716_wire", NULL);
	remove_proc_entry("pci1716_changes", NULL);
}

static int __init card_init(void)
{
	int status;

	status = -ENOMEM;
	if (!proc_create_single("pci1716_wire", 0444, NULL, show_wire) ||
	    !proc_create_seq_private("pci1716_changes", 0444, NULL, &change_ops, sizeof(struct reading), NULL))
		goto no_card;
	card = platform_device_register_simple("pci1716_card", -1, NULL, 0);
	if (IS_ERR(card)) {
		status = PTR_ERR(card);
		goto no_card;
	}
	status = comedi_driver_register(&card_driver);
	if (status)
		goto no_driver;
	status = comedi_auto_config(&card->dev, &card_driver, 0);
	if (status)
		goto no_config;
	return 0;

no_config:
	comedi_driver_unregister(&card_driver);
no_driver:
	platform_device_unregister(card);
no_card:
	remove_proc_entries();
	return status;
}
module_init(card_init);

static void __exit card_exit(void)
{
	comedi_auto_unconfig(&card->dev);
	comedi_driver_unregister(&card_driver);
	platform_device_unregister(card);
	remove_proc_entries();
}
module_exit(card_exit);

MODULE_DESCRIPTION("Stand-in for the Advantech PCI-1716, for tests");
MODULE_LICENSE("GPL");
