/* The functions of aomc_sky.h as external ones, for Fortran and others: compile this file with the program. */
#include "aomc_sky.h"
