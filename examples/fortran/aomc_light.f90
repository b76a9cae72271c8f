! The sky of aomc-sky in the AOMC program: takes the place of src/light_internal.f90 (version 1.2.2).
!
! AOMC keeps all its files, loops and outputs; only the direction of each photon comes from here. The photons of
! waveband `wavel` are those of aomc-sky for the amc.inp in the current folder, as many as the program
! launches. Environment: AOMC_SKY_SEED (0), AOMC_SKY_SCENE (another amc.inp or folder), AOMC_SKY_OPTIONS (words as in
! aomc_sky_embed.h, for example "weighting=projected" or "sky=uniform"). Where sky.toml says all, no difcol.inp is needed
! (aomc_difcol.c). See README.md for the build.
!
! theta is the zenith angle of the source and phi its azimuth, both in radians; the program's surface routine adds
! pi to phi, so that the photon travels away from the source.
subroutine light(wavenum, wavel, iteration, control)
    use, intrinsic :: iso_c_binding, only: c_float, c_int64_t
    use, intrinsic :: iso_fortran_env, only: error_unit
    use propagation_global, only: theta, phi
    use light_global, only: lsource, sky_nint
    use aomc_sky_embed
    implicit none
    integer, intent(in) :: wavenum    ! wavelength of the sky file
    integer, intent(in) :: wavel      ! waveband, from 1
    integer, intent(in) :: iteration  ! photon of the waveband, from 1
    integer, intent(inout) :: control ! 1 at the first photon of a waveband

    integer, parameter :: batch = 65536, r8 = kind(1d0)
    real(r8), parameter :: pi = 3.14159265358979324_r8
    real, parameter :: below_horizon = 1.570796 ! the program divides by cos(theta)
    ! The program logs phi in bin INT(phi / nphi) + 1 of phiint: 2 pi itself lies beyond the last bin, and so do, for
    ! 69 of the 360 numbers of bins, the next numbers below it in single precision. This one is in the last bin of all.
    real, parameter :: below_full_turn = 6.283184
    type(sky_scene), save :: scene
    type(sky_band), save :: band
    integer, save :: opened_iterations = -1, open_band = 0
    integer(c_int64_t), save :: first = 0, held = 0
    real(c_float), save :: ux(batch), uy(batch), uz(batch)
    integer(c_int64_t) :: photon
    real(r8) :: x, y, z
    integer :: at

    interface
        subroutine remove_difcol() bind(c, name="aomc_difcol_remove") ! aomc_difcol.c: what only the program reads
        end subroutine
    end interface

    if (control == 1 .or. wavel /= open_band) call start_band()
    photon = photon_of(int(iteration, c_int64_t))
    if (photon < first .or. photon >= first + held) then
        first = photon
        held = next_photons(band, first, ux, uy, uz)
        if (held <= 0) call fail("no photons came")
    end if
    at = int(photon - first) + 1
    x = -real(ux(at), r8)
    y = -real(uy(at), r8)
    z = -real(uz(at), r8)
    theta = min(real(atan2(sqrt(x * x + y * y), z)), below_horizon)
    phi = min(real(modulo(atan2(y, x), 2 * pi)), below_full_turn)

contains

    ! The program's own rounding decides how many photons a table's waveband has; 0 leaves it to amc.inp.
    subroutine start_band()
        integer :: iterations, status
        character(32) :: wanted
        iterations = 0
        if (lsource == 1) iterations = maxval(sky_nint(wavenum, :, :))
        if (iterations /= opened_iterations) then
            call remove_difcol()
            call close_scene(scene)
            wanted = ""
            if (iterations > 0) write (wanted, "(a, i0)") " iterations=", iterations
            call open_scene(setting("AOMC_SKY_SCENE", "amc.inp"), seed(), scene, status, &
                            setting("AOMC_SKY_OPTIONS", "") // trim(wanted))
            if (status /= 0) call fail(error_text())
            opened_iterations = iterations
        end if
        call get_band(scene, int(wavel - 1, c_int64_t), band, status)
        if (status /= 0) call fail(error_text())
        open_band = wavel
        first = 0
        held = 0
        control = 0
    end subroutine

    ! The program rounds intensity x iterations in 32 bits, which may add a few photons of some millions:
    ! these are the first ones again.
    function photon_of(number)
        integer(c_int64_t), intent(in) :: number
        integer(c_int64_t) :: photon_of
        if (number > band%n_photons + band%n_photons / 100000 + 1 .or. band%n_photons == 0) &
            call fail("the program launches more photons than the scene has; does it read the same amc.inp?")
        photon_of = modulo(number - 1, band%n_photons)
    end function

    function seed()
        integer(c_int64_t) :: seed
        integer :: status
        character(:), allocatable :: text
        text = setting("AOMC_SKY_SEED", "0")
        read (text, *, iostat=status) seed
        if (status /= 0) call fail("AOMC_SKY_SEED is no whole number")
    end function

    ! An environment variable, or what stands in for it.
    function setting(name, otherwise)
        character(*), intent(in) :: name, otherwise
        character(:), allocatable :: setting
        integer :: length
        call get_environment_variable(name, length=length)
        if (length == 0) then
            setting = otherwise
        else
            allocate (character(length) :: setting)
            call get_environment_variable(name, setting)
        end if
    end function

    subroutine fail(text) ! unit 6 is a file of the program's
        character(*), intent(in) :: text
        write (error_unit, "(2a)") "aomc-sky: ", text
        stop 1
    end subroutine
end subroutine
