/* Mutations for libFuzzer.  A file whose length changes is refused at its index, so most of them change some bytes in
 * their places only. */
#include "fuzz_target.h"

enum { MOST_WINDOW = 64 };

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed);

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed) {
    if (seed % 4 == 0 || size == 0)
        return LLVMFuzzerMutate(data, size, max_size);
    const size_t start = seed / 4 % size, left = size - start;
    const size_t wanted = 1 + seed / 4096 % MOST_WINDOW, window = wanted < left ? wanted : left;
    (void)LLVMFuzzerMutate(data + start, window, window);
    return size;
}
