/* Diversions, written from docs/fieldbus.md, "A belt that never stops". */
#include "diversions.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REQUEST = 200, REPLY = 300, MEMORY = 1000, QUEUE = 64, BINS = 32, CAPACITY = 1000, VERSION = 1 };
enum { LOOK = 0, RECALL = 3, STOP = 4, DIVERT = 6 };
enum { UNKNOWN, QUEUED, DONE, NOT_DONE, TOO_LATE };
enum {
    NONE = 0, EMERGENCY_STOP = 1, OTHER_COMMAND = 5, NO_SUCH_BIN = 6, BIN_FULL = 7, NO_SUCH_VERB = 13, QUEUE_FULL = 14,
    ALREADY_DIVERTED = 15, OTHER_BOOT = 16
};
static const int64_t LEAD = 50000, WINDOW = 20000; /* micrometres */

struct diversion { uint64_t key; int64_t coordinate; int32_t object, bin; int phase, reason; };
struct outcome { int phase, reason; };

static uint16_t *all;
static FILE *record;
static struct diversion memory[MEMORY + QUEUE + 1]; /* in the order in which they were accepted */
static int stored, queued, bins, filled[BINS];
static uint32_t boot, forgotten;
static int64_t distance[BINS], position;
static double speed, stamp, moved_at; /* micrometres per second; times */
static double way;                    /* the position, before it is rounded */
static int moving, pressed;

int diversions_exist(void) { return all != NULL; }

static void forget(void) {
    for (int i = 0; i < stored && stored - queued > MEMORY; i++)
        if (memory[i].phase != QUEUED) {
            memmove(memory + i, memory + i + 1, (size_t)(--stored - i) * sizeof *memory);
            forgotten++, i--;
        }
}

static void end(struct diversion *it, int phase, int reason) {
    static const char *const phases[] = {"UNKNOWN", "QUEUED", "DONE", "NOT_DONE", "TOO_LATE"};
    it->phase = phase, it->reason = reason;
    fprintf(record, "{\"object\": %d, \"coordinate\": %lld, \"bin\": %d, \"phase\": \"%s\", \"boot\": %u, \"time\": %.6f}\n",
            it->object, (long long)it->coordinate, it->bin, phases[phase], boot, now());
    fflush(record);
}

static void carry_out(void) {
    for (int i = 0; i < stored; i++) {
        struct diversion *it = &memory[i];
        if (it->phase != QUEUED || position < it->coordinate + distance[it->bin]) continue;
        queued--;
        if (pressed) end(it, NOT_DONE, EMERGENCY_STOP);
        else if (filled[it->bin] >= CAPACITY) end(it, NOT_DONE, BIN_FULL);
        else filled[it->bin]++, end(it, DONE, NONE);
    }
    forget();
}

void diversions_run(void) {
    if (!all) return;
    stamp = now();
    if (moving) way += speed * (stamp - moved_at);
    moved_at = stamp;
    position = (int64_t)floor(way);
    carry_out();
}

static struct diversion *find(uint64_t key) {
    for (int i = 0; i < stored; i++)
        if (memory[i].key == key) return &memory[i];
    return NULL;
}

static int refusal(const struct diversion *order, uint32_t measured) {
    int awaited = 0;
    if (!order->key) return OTHER_COMMAND;
    if (measured != boot) return OTHER_BOOT;
    if (pressed) return EMERGENCY_STOP;
    if (order->bin < 0 || order->bin >= bins) return NO_SUCH_BIN;
    for (int i = 0; i < stored; i++) {
        int64_t apart = memory[i].coordinate - order->coordinate;
        if (memory[i].object == order->object || (apart >= -WINDOW && apart <= WINDOW)) return ALREADY_DIVERTED;
        awaited += memory[i].phase == QUEUED && memory[i].bin == order->bin;
    }
    if (filled[order->bin] + awaited >= CAPACITY) return BIN_FULL;
    return queued >= QUEUE ? QUEUE_FULL : NONE;
}

static struct outcome divert(struct diversion order, uint32_t measured) {
    struct diversion *known = find(order.key), *it;
    int reason;
    if (known && measured == boot) {
        int same = known->object == order.object && known->coordinate == order.coordinate && known->bin == order.bin;
        return same ? (struct outcome){known->phase, known->reason} : (struct outcome){NOT_DONE, OTHER_COMMAND};
    }
    if ((reason = refusal(&order, measured)) != NONE) return (struct outcome){NOT_DONE, reason};
    it = &memory[stored++];
    *it = order, it->phase = QUEUED, it->reason = NONE;
    if (position > order.coordinate + distance[order.bin] - LEAD) {
        end(it, TOO_LATE, NONE);
        forget();
        return (struct outcome){TOO_LATE, NONE};
    }
    queued++;
    return (struct outcome){QUEUED, NONE};
}

static struct outcome act(int verb, struct diversion order, uint32_t measured) {
    struct diversion *known;
    switch (verb) {
    case LOOK:
        return (struct outcome){DONE, NONE};
    case RECALL:
        known = find(order.key);
        return known ? (struct outcome){known->phase, known->reason} : (struct outcome){UNKNOWN, NONE};
    case STOP:
        moving = 0;
        return (struct outcome){DONE, NONE};
    case DIVERT:
        return divert(order, measured);
    }
    return (struct outcome){NOT_DONE, NO_SUCH_VERB};
}

static void show(uint16_t sequence, uint16_t verb, uint64_t key, struct outcome outcome) {
    uint16_t *r = all + REPLY;
    r[0] = VERSION, r[1] = sequence, r[2] = verb;
    put(r + 3, key, 4);
    r[7] = (uint16_t)outcome.phase, r[8] = (uint16_t)outcome.reason;
    put(r + 9, boot, 2);
    put(r + 11, (uint64_t)position, 4);
    put(r + 15, (uint64_t)(1e6 * stamp), 4);
    r[19] = (uint16_t)((moving ? 1 : 0) | (pressed ? 2 : 0));
    r[20] = (uint16_t)queued;
    put(r + 21, forgotten, 2);
    r[23] = (uint16_t)bins;
    for (int i = 0; i < bins; i++) r[24 + i] = (uint16_t)filled[i];
}

int diversions_handle(int lose) {
    if (!all) return 0;
    const uint16_t *r = all + REQUEST;
    uint16_t ahead = (uint16_t)(r[0] - all[REPLY + 1]);
    if (ahead == 0 || ahead >= 32768) return 0;
    struct diversion order = {get(r + 2, 4), (int64_t)get(r + 8, 4), (int32_t)get(r + 6, 2), (int32_t)get(r + 12, 2), 0, 0};
    diversions_run();
    struct outcome outcome = act(r[1], order, (uint32_t)get(r + 14, 2));
    if (lose && r[1] == DIVERT) return 1;
    show(r[0], r[1], order.key, outcome);
    return 0;
}

int diversions_button(const char *line) {
    if (!all) return 0;
    diversions_run();
    if (!strcmp(line, "press")) pressed = 1, moving = 0;
    else if (!strcmp(line, "release")) pressed = 0;
    else if (!strcmp(line, "fill") || !strcmp(line, "empty"))
        for (int i = 0; i < bins; i++) filled[i] = line[0] == 'f' ? CAPACITY : 0;
    else if (!strcmp(line, "start")) {
        moving = !pressed;
        return 1;
    }
    return 0;
}

void diversions_begin(uint16_t *registers, uint32_t id, double metres, const char *path, int count, char **distances) {
    all = registers, boot = id, speed = 1e6 * metres, bins = count < BINS ? count : BINS, moving = 1;
    for (int i = 0; i < bins; i++) distance[i] = llround(1e6 * atof(distances[i]));
    if (!(record = fopen(path, "a"))) perror(path), exit(2);
    stamp = moved_at = now();
    show(0, LOOK, 0, (struct outcome){DONE, NONE});
}
