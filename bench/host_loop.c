/* The loop of a host in C: batches of a band into the same arrays, and the directions added up. */
#include <stdint.h>

#include "aomc_sky.h"

double c_loop(aomc_sky_next next, void *context, int64_t n, int64_t batch, float *ux, float *uy, float *uz, int adds)
{
    double total = 0;
    for (int64_t start = 0; start < n; start += batch) {
        const int64_t m = next(context, start, batch, ux, uy, uz);
        if (m <= 0) {
            return 1;
        }
        for (int64_t i = 0; adds && i < m; i++) {
            total += ux[i] + uy[i] + uz[i];
        }
    }
    return total;
}
