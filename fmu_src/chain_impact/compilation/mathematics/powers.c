/* pow and exp for a browser, with the digits of glibc's on processors that multiply and add in one instruction. And hypot
   for contact laws of users, whose last digit may be another one than glibc's.

   The algorithm, its tables (musl/pow_data.c, musl/exp_data.c) and the names are those of Arm's optimized routines:
   glibc 2.28 and musl 1.2 have it, too. WebAssembly has no such instruction, so musl's own pow.c rounds otherwise in
   one case of a thousand. Here `fma` stands wherever glibc's compiler puts one.

   Copyright (c) 2018, Arm Limited. SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdint.h>

#include "exp_data.h"
#include "libm.h"
#include "pow_data.h"

#define EXP __exp_data
#define LOG __pow_log_data
enum { EXP_COUNT = 1 << EXP_TABLE_BITS, LOG_COUNT = 1 << POW_LOG_TABLE_BITS };
static const uint64_t LEAST_OF_TABLE = 0x3fe6955500000000;
static const double SPLITTER = 0x1p27 + 1;

/* The sum of two numbers, and what its rounding leaves out (Knuth). */
static inline double sum(double a, double b, double *rest) {
    double whole = a + b, from_b = whole - a;
    *rest = (a - (whole - from_b)) + (b - from_b);
    return whole;
}

/* The product of two numbers below 2^996, and what its rounding leaves out (Dekker). */
static inline double product(double a, double b, double *rest) {
    double ahi = SPLITTER * a, bhi = SPLITTER * b;
    ahi -= ahi - a;
    bhi -= bhi - b;
    double alo = a - ahi, blo = b - bhi, whole = a * b;
    *rest = ((ahi * bhi - whole) + ahi * blo + alo * bhi) + alo * blo;
    return whole;
}

/* a b + c, rounded once: what is small is added so that it never lies in the middle between two numbers (Boldo &
   Melquiond, Emulation of FMA and correctly rounded sums, IEEE Transactions on Computers 57, 2008). */
static inline double fused(double a, double b, double c) {
    double low, rest, left, high = sum(product(a, b, &low), c, &rest);
    double small = sum(rest, low, &left);
    if (left != 0.0 && !(asuint64(small) & 1)) /* round to odd */
        small = asdouble(asuint64(small) + ((left > 0.0) == (small > 0.0) ? 1 : -1));
    return high + small;
}

/* The logarithm of a positive number that is not subnormal, and about 15 bits beyond its rounding. */
static double logarithm(uint64_t ix, double *tail) {
    const double *A = LOG.poly;
    uint64_t tmp = ix - LEAST_OF_TABLE;
    int i = (tmp >> (52 - POW_LOG_TABLE_BITS)) % LOG_COUNT;
    double z = asdouble(ix - (tmp & 0xfffULL << 52)), kd = (double)((int64_t)tmp >> 52);
    double r = fused(z, LOG.tab[i].invc, -1.0);
    double t1 = fused(kd, LOG.ln2hi, LOG.tab[i].logc), t2 = t1 + r;
    double lo1 = fused(kd, LOG.ln2lo, LOG.tab[i].logctail), lo2 = t1 - t2 + r;
    double ar = A[0] * r, ar2 = r * ar, ar3 = r * ar2;
    double hi = t2 + ar2, lo3 = fused(ar, r, -ar2), lo4 = t2 - hi + ar2;
    double p = fused(ar2, fused(ar2, fused(r, A[6], A[5]), fused(r, A[4], A[3])), fused(r, A[2], A[1]));
    double lo = fused(ar3, p, lo1 + lo2 + lo3 + lo4), y = hi + lo;
    *tail = hi - y + lo;
    return y;
}

/* exp(x + tail), for 2^-54 < |x| < 708. */
static double exponential(double x, double xtail) {
    const double *C = EXP.poly;
    double shifted = fused(EXP.invln2N, x, EXP.shift), kd = shifted - EXP.shift;
    uint64_t ki = asuint64(shifted), at = 2 * (ki % EXP_COUNT);
    double r = fused(kd, EXP.negln2loN, fused(kd, EXP.negln2hiN, x)) + xtail;
    double tail = asdouble(EXP.tab[at]), scale = asdouble(EXP.tab[at + 1] + (ki << (52 - EXP_TABLE_BITS)));
    double r2 = r * r, low = fused(r2, fused(r, C[1], C[0]), tail + r);
    return fused(scale, fused(r2 * r2, fused(r, C[3], C[2]), low), scale);
}

/* The same, for any x. */
static double any_exponential(double x, double tail) {
    if (!(fabs(x) > 0x1p-54)) return 1.0 + x; /* also of what is no number */
    if (fabs(x) < 708.0) return exponential(x, tail);
    if (x > 710.0) return HUGE_VAL;
    if (x < -746.0) return 0.0;
    double half = exponential(0.5 * x, 0.5 * tail); /* near the ends of the range, where the last digits may differ */
    return half * half;
}

double exp(double x) { return any_exponential(x, 0.0); }

/* x^y for x > 0, both finite and not zero. */
static double power(double x, double y) {
    uint64_t ix = asuint64(x);
    if (x < 0x1p-1022) ix = asuint64(x * 0x1p52) - (52ULL << 52);
    double tail, log = logarithm(ix, &tail);
    if (fabs(y) > 0x1p64) return (log > 0.0) == (y > 0.0) ? (log == 0.0 ? 1.0 : HUGE_VAL) : log == 0.0 ? 1.0 : 0.0;
    double high = y * log, rest;
    product(y, log, &rest);
    return any_exponential(high, fused(y, tail, rest));
}

/* Whether a number is an odd integer. */
static int odd(double y) { return fabs(y) < 0x1p53 && floor(y) == y && floor(0.5 * y) != 0.5 * y; }

double pow(double x, double y) {
    if (y == 0.0 || x == 1.0) return 1.0;
    if (isnan(x) || isnan(y)) return x + y;
    double sign = x < 0.0 && odd(y) ? -1.0 : 1.0, size = fabs(x);
    if (size == 0.0 || isinf(size)) {
        double value = (size == 0.0) == (y > 0.0) ? 0.0 : HUGE_VAL;
        return odd(y) ? copysign(value, x) : value;
    }
    if (isinf(y)) return size == 1.0 ? 1.0 : (size > 1.0) == (y > 0.0) ? HUGE_VAL : 0.0;
    if (x < 0.0 && floor(y) != y) return __math_invalid(x);
    return sign * power(size, y);
}

/* The square root of x^2 + y^2, with a step of Newton's method in twice the precision. The squares must be finite, and
   not subnormal. */
double hypot(double x, double y) {
    double of_x, of_y, rest, error;
    double squares = sum(product(x, x, &of_x), product(y, y, &of_y), &rest), root = sqrt(squares);
    if (root == 0.0 || !isfinite(root)) return root;
    double left = squares - product(root, root, &error);
    return root + (left - error + rest + of_x + of_y) / (2.0 * root);
}
