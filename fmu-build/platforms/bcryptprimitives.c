/* What Rust's hash maps want of Windows, for versions of Wine that do not have it yet. */
#include <stddef.h>

unsigned char SystemFunction036(void *bytes, unsigned long count);

__declspec(dllexport) int ProcessPrng(unsigned char *bytes, size_t count) {
    return SystemFunction036(bytes, (unsigned long)count);
}
