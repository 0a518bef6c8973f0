/* A controller for belt and sorter over Modbus TCP, with the world that it moves: the drops are counted there.

   It is written from docs/fieldbus.md alone and shares no code with beltsort. Usage: controller WORLD SPEED PORT, and for
   a belt that never stops (diversions.c) METRES_PER_SECOND RECORD DISTANCE...

   WORLD is a file that outlives this program, as the belt outlives its controller: see `struct world`. It listens on
   127.0.0.1, on a free port if PORT is 0, and prints "listening PORT". Lines on standard input:

     at N F        when the N-th command of this process has done the part F of its motion, print "trigger", and hold time
                   still until "go"; F above 1: when it has ended, before its end is told
     press         press the emergency stop      release       release it
     cut MS        close every connection, and accept none for so long
     garbage       the reply's registers hold nonsense until the next request
     stuck, overshoot, slip, lose   befall the next command: the belt does not move; moves one place too far and tells
                   it; moves one place too far and says "done", though its sensor tells the place; it acts, but the
                   request is not acknowledged
     jog           when the next command ends, somebody pushes the belt on by one place
     fill          every bin is full              empty         none is
     echo          print "echo"
     start         start the belt that never stops; press, release, fill, empty and lose concern it too
*/
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <modbus/modbus.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <arpa/inet.h>
#include <time.h>
#include <unistd.h>
#include "diversions.h"

enum { OBJECTS = 4096, MEMORY = 1000, BINS = 5, CLIENTS = 8, REGISTERS = 356, REPLY = 100, REPLY_COUNT = 52 };
enum { LOOK, ADVANCE, SORT, RECALL, STOP, HOME };
enum { FORGOTTEN, RUNNING, DONE, NOT_DONE, BROKEN_OFF };
enum {
    NONE, EMERGENCY_STOP, NOT_HOMED, BUSY, BACKWARDS, OTHER_COMMAND, NO_SUCH_BIN, BIN_FULL, ALREADY_SORTED,
    BETWEEN_OBJECTS, STOPPED, STUCK, OVERSHOT, NO_SUCH_VERB
};
static const double ADVANCE_SECONDS = 0.6, SORT_SECONDS = 0.4, RELEASE_AT = 0.6, NEAR = 0.1;

/* What is true, whatever the controller thinks. */
struct world {
    double belt;            /* place at the belt end: object n is there at n */
    int32_t bin[OBJECTS];   /* 1 + the bin that it lies in; 0: on the belt */
    int32_t drops[OBJECTS]; /* how often the gripper was opened for this place */
};

struct record { uint64_t key; int verb, target, phase, reason; double end; };

static struct world *world;
static double speed;

static struct record memory[MEMORY];
static int remembered;
static uint32_t forgotten;
static struct record *running;
static double begin, from, distance; /* of the running command */
static int released;                 /* whether the gripper has opened in it */
static uint32_t boot;
static double encoder;               /* where the controller believes the belt to be */
static int homed, fault = NOT_HOMED, emergency_stop, sorted = -1;
static int stuck, overshoot, slip, lose, jog, full;
static int commands, trigger_command;
static double trigger_part, deaf_until;

double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int at_place(double belt) { return fabs(belt - nearbyint(belt)) < NEAR; }

static void end(int phase, int reason) {
    running->phase = phase, running->reason = reason, running->end = now();
    running = NULL;
    if (jog) world->belt += 1.0, encoder += 1.0;
    jog = 0;
}

static void break_off(int reason) {
    if (running) end(BROKEN_OFF, reason);
}

/* Open the gripper over whatever stands at the belt end. */
static void release_object(int bin) {
    int object = (int)nearbyint(world->belt);
    released = 1;
    if (!at_place(world->belt) || object < 0 || object >= OBJECTS) return;
    world->drops[object]++;
    if (!world->bin[object]) world->bin[object] = 1 + bin;
}

static void arrive(void) {
    if (stuck) {
        stuck = 0, fault = STUCK;
        end(NOT_DONE, STUCK);
        return;
    }
    if (overshoot || slip) world->belt += 1.0, encoder += 1.0;
    if (overshoot) fault = OVERSHOT;
    int phase = overshoot ? BROKEN_OFF : DONE, reason = overshoot ? OVERSHOT : NONE;
    overshoot = slip = 0;
    end(phase, reason);
}

static void serve_panel(int until_go);

static void move(void) {
    if (!running) return;
    double seconds = (running->verb == SORT ? SORT_SECONDS : ADVANCE_SECONDS * fmax(fabs(distance), 0.1)) / speed;
    double part = fmin(1.0, (now() - begin) / seconds);
    int triggered = trigger_command == commands && (part >= trigger_part || (part >= 1.0 && trigger_part > 1.0));
    if (triggered && trigger_part <= 1.0) part = trigger_part;
    if (running->verb == ADVANCE && !stuck) {
        double to = from + distance * part;
        world->belt += to - encoder, encoder = to;
    }
    if (running->verb == SORT && part >= RELEASE_AT && !released) release_object(running->target);
    if (triggered) {
        double paused = now();
        trigger_command = 0;
        printf("trigger\n");
        fflush(stdout);
        serve_panel(1);
        begin += now() - paused;
        if (!running) return;
    }
    if (part < 1.0) return;
    if (running->verb == SORT) sorted = (int)nearbyint(encoder), end(DONE, NONE);
    else arrive();
}

static struct record *find(uint64_t key) {
    for (int i = 0; i < remembered; i++)
        if (memory[i].key == key) return &memory[i];
    return NULL;
}

static struct record *remember(uint64_t key) {
    struct record *old = find(key);
    if (old) return old;
    if (remembered == MEMORY) {
        memmove(memory, memory + 1, (MEMORY - 1) * sizeof *memory);
        remembered--, forgotten++;
    }
    return &memory[remembered++];
}

static int refusal(int verb, int target) {
    int place = (int)nearbyint(encoder);
    if (emergency_stop) return EMERGENCY_STOP;
    if (fault) return fault;
    if (running) return BUSY;
    if (verb == ADVANCE) return target < encoder - NEAR ? BACKWARDS : NONE;
    if (target < 0 || target >= BINS) return NO_SUCH_BIN;
    if (!at_place(encoder)) return BETWEEN_OBJECTS;
    if (sorted == place) return ALREADY_SORTED;
    return full ? BIN_FULL : NONE;
}

static struct record command(int verb, int target, uint64_t key) {
    struct record answer = {key, verb, target, NOT_DONE, key ? NONE : OTHER_COMMAND, now()}, *old = find(key);
    if (!key) return answer;
    if (old && old->phase != NOT_DONE) {
        if (old->verb == verb && old->target == target) return *old;
        answer.reason = OTHER_COMMAND;
        return answer;
    }
    if ((answer.reason = refusal(verb, target)) != NONE) return answer;
    commands++;
    running = remember(key);
    *running = (struct record){key, verb, target, RUNNING, NONE, 0.0};
    begin = now(), from = encoder, distance = target - encoder, released = 0;
    struct record *it = running;
    move();
    return *it;
}

static struct record act(int verb, int target, uint64_t key) {
    struct record answer = {key, verb, target, DONE, NONE, now()}, *known;
    switch (verb) {
    case ADVANCE:
    case SORT:
        return command(verb, target, key);
    case RECALL:
        known = find(key);
        if (known) return *known;
        answer.phase = FORGOTTEN;
        return answer;
    case STOP:
        break_off(STOPPED);
        return answer;
    case HOME:
        if (emergency_stop || running) {
            answer.phase = NOT_DONE, answer.reason = emergency_stop ? EMERGENCY_STOP : BUSY;
            return answer;
        }
        encoder = target, homed = 1, fault = NONE, sorted = -1;
        return answer;
    case LOOK:
        return answer;
    }
    answer.phase = NOT_DONE, answer.reason = NO_SUCH_VERB;
    return answer;
}

void put(uint16_t *registers, uint64_t value, int count) {
    for (int i = count - 1; i >= 0; i--, value >>= 16) registers[i] = (uint16_t)value;
}

uint64_t get(const uint16_t *registers, int count) {
    uint64_t value = 0;
    for (int i = 0; i < count; i++) value = value << 16 | registers[i];
    return value;
}

static void show(uint16_t *r, uint16_t sequence, int verb, struct record answer) {
    double age = answer.phase == RUNNING ? 0.0 : 1000.0 * (now() - answer.end);
    int position = homed && !running && at_place(encoder) ? (int)nearbyint(encoder) : -1;
    int bins[BINS] = {0};
    for (int i = 0; i < OBJECTS; i++)
        if (world->bin[i]) bins[world->bin[i] - 1]++;
    r[0] = sequence, r[1] = (uint16_t)verb;
    put(r + 2, answer.key, 4);
    r[6] = (uint16_t)answer.phase, r[7] = (uint16_t)answer.reason;
    put(r + 8, (uint64_t)age, 2);
    put(r + 10, boot, 2);
    put(r + 12, (uint64_t)(int64_t)position, 2);
    r[14] = (uint16_t)remembered;
    put(r + 15, forgotten, 2);
    r[17] = (uint16_t)((fault == NONE && !emergency_stop ? 1 : 0) | (emergency_stop ? 2 : 0));
    r[18] = (uint16_t)fault, r[19] = BINS;
    for (int i = 0; i < BINS; i++) r[20 + i] = (uint16_t)bins[i];
}

static modbus_t *bus;
static modbus_mapping_t *registers;
static int listener, clients[CLIENTS];

/* Act on the request in the registers if its sequence is new. */
static void handle(void) {
    const uint16_t *request = registers->tab_registers;
    uint16_t *reply = registers->tab_registers + REPLY, sequence = request[0], last = reply[0];
    uint16_t ahead = (uint16_t)(sequence - last);
    if (ahead == 0 || ahead >= 32768) return;
    int verb = request[1], target = (int32_t)get(request + 2, 2);
    move();
    struct record answer = act(verb, target, get(request + 4, 4));
    if (lose && (verb == ADVANCE || verb == SORT)) {
        lose = 0;
        return;
    }
    show(reply, sequence, verb, answer);
}

static void drop_client(int i) {
    close(clients[i]);
    clients[i] = -1;
}

static void press_button(const char *line) {
    int number, milliseconds;
    double part;
    if (diversions_button(line)) return;
    if (sscanf(line, "at %d %lf", &number, &part) == 2) trigger_command = commands + number, trigger_part = part;
    else if (!strcmp(line, "press")) break_off(EMERGENCY_STOP), emergency_stop = 1;
    else if (!strcmp(line, "echo")) printf("echo\n"), fflush(stdout);
    else if (!strcmp(line, "release")) emergency_stop = 0;
    else if (sscanf(line, "cut %d", &milliseconds) == 1) {
        deaf_until = now() + milliseconds / 1000.0;
        for (int i = 0; i < CLIENTS; i++)
            if (clients[i] >= 0) drop_client(i);
    } else if (!strcmp(line, "garbage"))
        memset(registers->tab_registers + REPLY + 1, 0x57, 2 * (REPLY_COUNT - 1));
    else if (!strcmp(line, "stuck")) stuck = 1;
    else if (!strcmp(line, "overshoot")) overshoot = 1;
    else if (!strcmp(line, "slip")) slip = 1;
    else if (!strcmp(line, "lose")) lose = 1;
    else if (!strcmp(line, "jog")) jog = 1;
    else if (!strcmp(line, "fill")) full = 1;
    else if (!strcmp(line, "empty")) full = 0;
    else fprintf(stderr, "controller: no such button: %s\n", line), exit(2);
}

/* Read lines from standard input: those that are there, or until "go". */
static void serve_panel(int until_go) {
    static char buffer[4096];
    static size_t filled;
    for (;;) {
        char *newline = memchr(buffer, '\n', filled);
        if (newline) {
            char line[256] = {0};
            size_t length = (size_t)(newline - buffer);
            memcpy(line, buffer, length < sizeof line - 1 ? length : sizeof line - 1);
            memmove(buffer, newline + 1, filled -= length + 1);
            if (!strcmp(line, "go")) return;
            press_button(line);
            continue;
        }
        fd_set set;
        struct timeval none = {0, 0};
        FD_ZERO(&set);
        FD_SET(0, &set);
        if (select(1, &set, NULL, NULL, until_go ? NULL : &none) <= 0) return;
        ssize_t got = read(0, buffer + filled, sizeof buffer - filled);
        if (got <= 0) exit(0);
        filled += (size_t)got;
    }
}

static void serve(int i) {
    uint8_t query[MODBUS_TCP_MAX_ADU_LENGTH];
    modbus_set_socket(bus, clients[i]);
    int length = modbus_receive(bus, query);
    if (length < 0) {
        drop_client(i);
        return;
    }
    if (length == 0) return;
    int written = query[modbus_get_header_length(bus)] == MODBUS_FC_WRITE_MULTIPLE_REGISTERS;
    if (modbus_reply(bus, query, length, registers) < 0) drop_client(i);
    if (written) handle();
    if (written && diversions_handle(lose)) lose = 0;
}

static void welcome(void) {
    int client = accept(listener, NULL, NULL);
    for (int i = 0; client >= 0 && i < CLIENTS; i++)
        if (clients[i] < 0) {
            clients[i] = client;
            return;
        }
    if (client >= 0) close(client);
}

int main(int argc, char **argv) {
    if (argc != 4 && argc < 7)
        return fprintf(stderr, "usage: controller WORLD SPEED PORT [METRES_PER_SECOND RECORD DISTANCE...]\n"), 2;
    int file = open(argv[1], O_RDWR | O_CREAT, 0600), random = open("/dev/urandom", O_RDONLY);
    if (file < 0 || ftruncate(file, sizeof *world) || random < 0) return perror(argv[1]), 2;
    world = mmap(NULL, sizeof *world, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (world == MAP_FAILED) return perror("mmap"), 2;
    speed = atof(argv[2]);
    do
        if (read(random, &boot, sizeof boot) != sizeof boot) return perror("urandom"), 2;
    while (!boot);
    for (int i = 0; i < CLIENTS; i++) clients[i] = -1;
    bus = modbus_new_tcp("127.0.0.1", atoi(argv[3]));
    registers = modbus_mapping_new(0, 0, REGISTERS, 0);
    if (!bus || !registers || (listener = modbus_tcp_listen(bus, 4)) < 0) return perror("modbus"), 2;
    struct sockaddr_in name;
    socklen_t size = sizeof name;
    if (getsockname(listener, (struct sockaddr *)&name, &size)) return perror("getsockname"), 2;
    show(registers->tab_registers + REPLY, 0, LOOK, (struct record){0, LOOK, 0, DONE, NONE, now()});
    if (argc > 4) diversions_begin(registers->tab_registers, boot, atof(argv[4]), argv[5], argc - 6, argv + 6);
    printf("listening %d\n", ntohs(name.sin_port));
    fflush(stdout);
    for (;;) {
        fd_set set;
        int highest = 0;
        struct timeval tick = {0, 1000};
        FD_ZERO(&set);
        FD_SET(0, &set);
        if (now() >= deaf_until) FD_SET(listener, &set), highest = listener;
        for (int i = 0; i < CLIENTS; i++)
            if (clients[i] >= 0) {
                FD_SET(clients[i], &set);
                if (clients[i] > highest) highest = clients[i];
            }
        int awake = running || now() < deaf_until || diversions_exist();
        if (select(highest + 1, &set, NULL, NULL, awake ? &tick : NULL) < 0 && errno != EINTR) return perror("select"), 2;
        move();
        diversions_run();
        serve_panel(0); /* always: lines may be in its buffer */
        if (now() >= deaf_until && FD_ISSET(listener, &set)) welcome();
        for (int i = 0; i < CLIENTS; i++)
            if (clients[i] >= 0 && FD_ISSET(clients[i], &set)) serve(i);
    }
}
