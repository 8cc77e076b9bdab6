/* The processor's registers that say how it computes with floating-point numbers: rounding, what becomes of denormal
   numbers, and which exceptions end the process. An importer may have set them otherwise than C sets them at the start
   of a process. The standard lets an FMU change them for the time of a call. */
#ifndef registers_h
#define registers_h

#include <stdint.h>

/* Set them as at the start of a process; returns what they were. */
uint64_t usual_registers(void);
void put_registers_back(uint64_t registers);

#endif
