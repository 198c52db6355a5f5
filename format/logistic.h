/* Mixing of probabilities in the logistic domain, in integers (spec, section "Range coder"): as in PAQ (Mahoney 2005),
 * votes are logarithms of odds, their weighted sum is squashed to a probability, and the weights follow the error's
 * gradient. */
#ifndef NSDF_LOGISTIC_H
#define NSDF_LOGISTIC_H

#include <stdint.h>

enum {
    NSDF_LOGIT_MAX = 2047,          /* logarithms of odds are in units of 1/256: about -8 to 8 */
    NSDF_STRETCH_SIZE = 4096,       /* probabilities are stretched in steps of 1/4096 */
    NSDF_MODEL_LIMIT = 254,         /* decisions that a model counts */
    NSDF_MIX_WEIGHT_MAX = 1 << 18,  /* weights are in units of 1/65536: -4 to 4, so that sums of four fit 32 bits */
    NSDF_MIX_WEIGHT_START = 5 << 12 /* 0.3125 */
};

/* An estimate, in 1/65536, of the probability that a decision is 0, and the decisions seen. */
typedef struct nsdf_bit_model {
    uint16_t zero, seen;
} nsdf_bit_model;

/* What depends on nothing but the text of the specification. */
typedef struct nsdf_logistic_tables {
    int16_t stretch[NSDF_STRETCH_SIZE];
    uint16_t rates[NSDF_MODEL_LIMIT + 1]; /* by the decisions seen, in 1/65536: as a Krichevsky-Trofimov estimator */
    uint16_t trust[NSDF_MODEL_LIMIT + 1]; /* by the decisions seen, in 1/256: how far a model's vote counts */
} nsdf_logistic_tables;

/* 65536 / (1 + exp(-logit / 256)), between the 65 values that the specification lists; 22 to 65514. */
static inline uint32_t nsdf_squash(int32_t logit) {
    static const uint16_t half[33] = {22,   28,   36,   47,   60,    77,    98,    126,   162,   208,   267,
                                      342,  439,  562,  720,  922,   1179,  1506,  1921,  2446,  3108,  3938,
                                      4971, 6249, 7812, 9702, 11955, 14595, 17625, 21025, 24743, 28693, 32768};
    const uint32_t at = (uint32_t)(logit + NSDF_LOGIT_MAX + 1), i = at >> 6;
    const uint32_t low = i <= 32 ? half[i] : 65536u - half[64 - i];
    const uint32_t high = i < 32 ? half[i + 1] : 65536u - half[63 - i];
    return low + ((high - low) * (at & 63) >> 6);
}

/* stretch[p] is the least logit whose probability is at or above the middle of step p, or the largest logit. */
static inline void nsdf_logistic_fill(nsdf_logistic_tables *t) {
    int32_t logit = -NSDF_LOGIT_MAX;
    for (uint32_t p = 0; p < NSDF_STRETCH_SIZE; p++) {
        while (logit < NSDF_LOGIT_MAX && nsdf_squash(logit) < 16 * p + 8)
            logit++;
        t->stretch[p] = (int16_t)logit;
    }
    for (uint32_t n = 0; n <= NSDF_MODEL_LIMIT; n++) {
        t->rates[n] = (uint16_t)(65536 / (n + 2));
        t->trust[n] = (uint16_t)(256 * n / (n + 1));
    }
}

/* Moves the estimate towards 65536 (bit 0) or 0 (bit 1).  Rates are at most 1/2, so that it stays inside. */
static inline void nsdf_bit_update(nsdf_bit_model *m, uint32_t bit, const nsdf_logistic_tables *t) {
    const uint32_t p = m->zero, rate = t->rates[m->seen];
    m->zero = (uint16_t)(bit ? p - (p * rate >> 16) : p + ((65536 - p) * rate >> 16));
    m->seen = (uint16_t)(m->seen < NSDF_MODEL_LIMIT ? m->seen + 1 : m->seen);
}

static inline int32_t nsdf_bit_vote(const nsdf_bit_model *m, const nsdf_logistic_tables *t) {
    return t->stretch[m->zero >> 4] * (int32_t)t->trust[m->seen] / 256;
}

/* Sum of at most four votes by their weights. */
static inline int32_t nsdf_mix(const int32_t *votes, const int32_t *weights, uint32_t count) {
    int32_t sum = 0;
    for (uint32_t i = 0; i < count; i++)
        sum += votes[i] * weights[i];
    sum /= 65536;
    return sum > NSDF_LOGIT_MAX ? NSDF_LOGIT_MAX : sum < -NSDF_LOGIT_MAX ? -NSDF_LOGIT_MAX : sum;
}

/* `zero` is the probability that the mix gave. */
static inline void nsdf_mix_learn(const int32_t *votes, int32_t *weights, uint32_t count, uint32_t zero, uint32_t bit) {
    const int32_t error = (bit ? 0 : 65536) - (int32_t)zero;
    for (uint32_t i = 0; i < count; i++) {
        const int32_t w = weights[i] + error * votes[i] / 32768;
        weights[i] = w > NSDF_MIX_WEIGHT_MAX    ? NSDF_MIX_WEIGHT_MAX
                     : w < -NSDF_MIX_WEIGHT_MAX ? -NSDF_MIX_WEIGHT_MAX
                                                : w;
    }
}

#endif
