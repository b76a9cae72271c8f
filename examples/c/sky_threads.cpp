// The same in C++, with threads that take blocks from a common counter.
//
//     sky_threads day.sky [THREADS]
#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

#include "example.h"

struct Sums {
    double cosine = 0;
    uint64_t bits = 0;
};

static Sums follow(const aomc_sky_source &source, unsigned n_threads)
{
    Sums sums;
    std::mutex lock;
    std::atomic<int64_t> next{0};
    auto work = [&] {
        std::vector<float> ux(BLOCK), uy(BLOCK), uz(BLOCK);
        Sums own;
        int64_t start, n;
        while ((start = next.fetch_add(BLOCK)) < source.n) {
            n = need(aomc_sky_fill(&source, start, BLOCK, ux.data(), uy.data(), uz.data()));
            for (int64_t i = 0; i < n; i++) { // here your photon goes its way
                own.cosine -= uz[i];
                own.bits ^= bits_of(start + i, ux[i], uy[i], uz[i]);
            }
        }
        std::lock_guard<std::mutex> held(lock);
        sums.cosine += own.cosine;
        sums.bits ^= own.bits;
    };
    std::vector<std::thread> pool;
    for (unsigned k = 0; k < n_threads; k++) pool.emplace_back(work);
    for (auto &thread : pool) thread.join();
    return sums;
}

int main(int argc, char **argv)
{
    aomc_sky_file file;
    aomc_sky_source source;
    if (argc < 2) return fprintf(stderr, "usage: %s FILE [THREADS]\n", argv[0]), 2;
    const int asked = argc > 2 ? atoi(argv[2]) : (int)std::thread::hardware_concurrency();
    need(aomc_sky_load(argv[1], &file));
    for (int32_t band = 0; band < file.n_bands; band++) {
        need(aomc_sky_band(&file, band, &source));
        const Sums sums = follow(source, asked > 0 ? (unsigned)asked : 1);
        report(source.wavelength_nm, source.n, sums.cosine, sums.bits);
    }
    aomc_sky_unload(&file);
}
