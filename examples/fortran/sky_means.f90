! The photons of a scene in a Fortran program: mean cosine of every band, any number of threads.
!
!   sky_means SCENE SEED [OPTIONS [FILE]]
!
! SCENE is amc.inp or its folder, OPTIONS are words like "precision=float64 order=patch"; either precision
! will do. FILE, if named, gets the directions as they come: all ux of a band, then all uy, then all uz.
program sky_means
    use, intrinsic :: iso_fortran_env, only: error_unit, int64, real32, real64
    use, intrinsic :: iso_c_binding, only: c_associated
    use aomc_sky_embed
    implicit none

    integer(int64), parameter :: batch = 65536
    type(sky_scene) :: scene
    type(sky_band) :: band
    integer(int64) :: seed, k
    integer :: status, unit
    logical :: keeps_file
    character(:), allocatable :: text

    if (command_argument_count() < 2 .or. command_argument_count() > 4) then
        write (error_unit, "(a)") "usage: sky_means SCENE SEED [OPTIONS [FILE]]"
        stop 2
    end if
    text = argument(2)
    read (text, *, iostat=status) seed
    if (status /= 0) call fail("SEED is no whole number")
    call open_scene(argument(1), seed, scene, status, argument(3))
    if (status /= 0) call fail(error_text())
    keeps_file = command_argument_count() == 4
    if (keeps_file) open (newunit=unit, file=argument(4), access="stream", form="unformatted", status="replace")

    write (*, "(3a12)") "nm", "photons", "mean cosine"
    do k = 0, n_bands(scene) - 1
        call get_band(scene, k, band, status)
        if (status /= 0) call fail(error_text())
        if (c_associated(band%next)) then
            call follow_single()
        else
            call follow_double()
        end if
    end do
    call close_scene(scene)

contains

    ! Every batch is a task of its own: photons depend on their index alone, so threads share nothing.
    subroutine follow_single()
        real(real32), allocatable :: u(:, :)
        integer(int64) :: start, stop
        real(real64) :: total
        integer :: failed
        allocate (u(band%n_photons, 3))
        total = 0
        failed = 0
        !$omp parallel do private(stop) reduction(+: total, failed) schedule(dynamic)
        do start = 1, band%n_photons, batch
            stop = min(start + batch - 1, band%n_photons)
            if (next_photons(band, start - 1, u(start:stop, 1), u(start:stop, 2), u(start:stop, 3)) &
                /= stop - start + 1) failed = failed + 1
            total = total - sum(real(u(start:stop, 3), real64)) ! here your photons go their way
        end do
        if (failed > 0) call fail("a batch failed")
        call report(total)
        if (keeps_file) write (unit) u
    end subroutine

    subroutine follow_double()
        real(real64), allocatable :: u(:, :)
        integer(int64) :: start, stop
        real(real64) :: total
        integer :: failed
        allocate (u(band%n_photons, 3))
        total = 0
        failed = 0
        !$omp parallel do private(stop) reduction(+: total, failed) schedule(dynamic)
        do start = 1, band%n_photons, batch
            stop = min(start + batch - 1, band%n_photons)
            if (next_photons(band, start - 1, u(start:stop, 1), u(start:stop, 2), u(start:stop, 3)) &
                /= stop - start + 1) failed = failed + 1
            total = total - sum(u(start:stop, 3))
        end do
        if (failed > 0) call fail("a batch failed")
        call report(total)
        if (keeps_file) write (unit) u
    end subroutine

    subroutine report(total)
        real(real64), intent(in) :: total
        write (*, "(f12.3, i12, f12.6)") band%wavelength_nm, band%n_photons, total / max(band%n_photons, 1_int64)
    end subroutine

    ! A word of the command line, empty where there is none.
    function argument(k) result(text)
        integer, intent(in) :: k
        character(:), allocatable :: text
        integer :: length
        call get_command_argument(k, length=length)
        allocate (character(length) :: text)
        if (length > 0) call get_command_argument(k, text)
    end function

    subroutine fail(text)
        character(*), intent(in) :: text
        write (error_unit, "(a)") text
        stop 1
    end subroutine
end program
