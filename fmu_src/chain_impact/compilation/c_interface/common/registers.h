/* The floating-point registers of the processor: how it rounds, whether it keeps denormal numbers, and which exceptions
   end the process. An importer may have changed these settings, so that results would differ. The standard allows an
   FMU to change the settings during a call. */
#ifndef registers_h
#define registers_h

#include <stdint.h>

/* Set the registers as at the start of a process; return the settings that they had, for put_registers_back. */
uint64_t usual_registers(void);
void put_registers_back(uint64_t registers);

/* In each file that includes this one, the compiler must not move arithmetic across the calls of these functions. */
#pragma STDC FENV_ACCESS ON

#endif
