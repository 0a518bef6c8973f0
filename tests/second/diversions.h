/* Diversions on a belt that never stops, and what they share with the rest of the controller. */
#ifndef DIVERSIONS_H
#define DIVERSIONS_H
#include <stdint.h>

/* Seconds on a clock that nobody sets. */
double now(void);
void put(uint16_t *registers, uint64_t value, int count);
uint64_t get(const uint16_t *registers, int count);

/* Begin with the belt at 0: its speed, metres per second, the file to which ended diversions are appended, and the
   distance of each diverter from the mark, metres. Without this there are no diversions. */
void diversions_begin(uint16_t *registers, uint32_t boot, double speed, const char *record, int bins, char **distances);
int diversions_exist(void);

/* Carry out what is due. */
void diversions_run(void);

/* Answer the request in the registers if it is new; with `lose`, a diversion without an acknowledgement. Return whether
   one was lost. */
int diversions_handle(int lose);

/* Push a button; return whether only diversions know it. */
int diversions_button(const char *line);
#endif
