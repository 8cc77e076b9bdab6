/* Each exported function of the kernel calls usual_registers at its start and put_registers_back at its end
   (compilation/collecting.py). Both functions are in a file of their own, so that no compiler moves arithmetic across
   calls of them. They also set and restore the flags of past exceptions, which the registers have. */
#include "registers.h"

#if defined(__x86_64__)

/* x86: exceptions masked, rounding to nearest, denormal numbers kept, no flags, as at the start of a process */
static const uint32_t USUAL = 0x1f80;

uint64_t usual_registers(void) {
    uint32_t before;
    __asm__ volatile("stmxcsr %0" : "=m"(before));
    __asm__ volatile("ldmxcsr %0" : : "m"(USUAL));
    return before;
}

void put_registers_back(uint64_t registers) {
    uint32_t before = (uint32_t)registers;
    __asm__ volatile("ldmxcsr %0" : : "m"(before));
}

#elif defined(__aarch64__)

/* aarch64: the result has the control register in its lower 32 bits, the flags in its upper 32 bits. At the start of a
   process both registers are 0. */
uint64_t usual_registers(void) {
    uint64_t control, flags;
    __asm__ volatile("mrs %0, fpcr" : "=r"(control));
    __asm__ volatile("mrs %0, fpsr" : "=r"(flags));
    put_registers_back(0);
    return flags << 32 | control;
}

void put_registers_back(uint64_t registers) {
    __asm__ volatile("msr fpcr, %0" : : "r"(registers & UINT32_MAX));
    __asm__ volatile("msr fpsr, %0" : : "r"(registers >> 32));
}

#endif
