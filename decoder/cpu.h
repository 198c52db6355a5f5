/* What this CPU and its operating system let us use. */
#ifndef NSDF_CPU_H
#define NSDF_CPU_H

#include <stdint.h>

/* Bits of NSDF_CPU_... (nsdf/decoder.h). */
uint32_t nsdf_cpu_features(void);

#endif
