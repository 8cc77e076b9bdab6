/* The floating-point registers of the processor: how it rounds, whether it keeps denormal numbers, and which exceptions
   end the process. An importer may have changed these settings, and results would differ. The standard allows an FMU to
   change them during a call. */
#ifndef registers_h
#define registers_h

#include <stdint.h>

/* Set the registers to the settings at the start of a process; return the settings before, for put_registers_back. */
uint64_t usual_registers(void);
void put_registers_back(uint64_t registers);

#endif
