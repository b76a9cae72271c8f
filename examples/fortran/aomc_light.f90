! The sky of aomc-sky in the AOMC program: takes the place of src/light_internal.f90 (version 1.2.2); README.md has the build.
! The photons come from day.sky, or from the file that AOMC_SKY_FILE names. theta is the zenith angle of the source and phi
! its azimuth; the program's surface routine adds pi to phi, so that the photon travels away from the source.
subroutine light(wavenum, wavel, iteration, control)
    use, intrinsic :: iso_fortran_env, only: int64, r8 => real64
    use const_global, only: lambda
    use light_global, only: intensity, lsource, sky_nint
    use propagation_global, only: theta, phi
    use aomc_sky
    implicit none
    integer, intent(in) :: wavenum, wavel, iteration ! waveband of skydist.inp; waveband and its photon, from 1
    integer, intent(inout) :: control                ! 1 at the first photon of a waveband
    real(r8), parameter :: pi = 3.14159265358979324_r8
    real, parameter :: below_horizon = 1.570796   ! the program divides by cos(theta)
    real, parameter :: below_full_turn = 6.283184 ! in the last bin INT(phi / nphi) + 1, for all numbers of bins up to 360
    type(aomc_sky_file), save :: file
    type(aomc_sky_source), save :: source
    integer, save :: band = 0
    type(aomc_sky_photon) :: p
    interface
        subroutine remove_difcol() bind(c, name="aomc_difcol_remove") ! aomc_difcol.c: what only the program reads
        end subroutine
    end interface

    if (control == 1 .or. wavel /= band) call start_band()
    p = aomc_sky_at(source, modulo(iteration - 1_int64, source%n)) ! those that rounding adds are the first ones again
    theta = min(real(atan2(sqrt(real(p%ux, r8)**2 + real(p%uy, r8)**2), -real(p%uz, r8))), below_horizon)
    phi = min(real(modulo(atan2(-real(p%uy, r8), -real(p%ux, r8)), 2 * pi)), below_full_turn)
contains
    ! The waveband of the file, if wavelength and photons are those that the program's own files ask for.
    subroutine start_band()
        integer :: iterations, unit, k
        integer(int64) :: requested
        real :: wavelength
        character(1000) :: path
        call remove_difcol()
        call get_environment_variable("AOMC_SKY_FILE", path, status=k)
        if (k /= 0) path = "day.sky"
        if (band == 0) k = aomc_sky_load(path, file)
        if (file%n_bands == 0) error stop "aomc-sky: " // trim(path) // ": " // aomc_sky_text(k)
        if (file%n_bands /= lambda) error stop "aomc-sky: amc.inp has another number of wavebands than " // trim(path)
        k = aomc_sky_band(file, wavel - 1, source)
        open (newunit=unit, file="lambbot.inp", status="old")
        do k = 0, wavel ! the first record is their number
            read (unit, *) wavelength
        end do
        close (unit)
        if (abs(source%wavelength_nm - wavelength) > 0.01) error stop "aomc-sky: wavelengths of lambbot.inp not in " // trim(path)
        open (newunit=unit, file="amc.inp", status="old")
        read (unit, "(48x, i12)") iterations
        close (unit)
        requested = iterations
        if (lsource == 0) requested = nint(intensity(wavel) * iterations, int64)
        if (lsource == 1) requested = merge(source%n, requested, source%n == maxval(sky_nint(wavenum, :, :))) ! its own rounding
        if (source%n == 0 .or. abs(source%n - requested) > requested / 100000 + 1) &
            error stop "aomc-sky: amc.inp (or difcol.inp) has other iterations than " // trim(path) // "; write it again"
        band = wavel
        control = 0
    end subroutine
end subroutine
