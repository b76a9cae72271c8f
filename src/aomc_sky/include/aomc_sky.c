/* The functions of aomc_sky.h as external ones, for Fortran and others: compile this file with the program. */
#define AOMC_SKY_API
#define AOMC_SKY_HOST_API
#include "aomc_sky.h"
