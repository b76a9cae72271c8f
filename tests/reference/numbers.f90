! Writes n1, n2, n3 of all photons of the first band, the third in a call of its own: numbers SCENE OPTIONS FILE
program numbers
    use, intrinsic :: iso_fortran_env, only: int64, real32, real64
    use, intrinsic :: iso_c_binding, only: c_associated
    use aomc_sky_embed
    implicit none
    type(sky_scene) :: scene
    type(sky_band) :: band
    integer :: status, unit
    integer(int64) :: n
    character(1000) :: words(3)
    real(real32), allocatable :: u(:, :), three(:, :)
    real(real64), allocatable :: v(:, :)

    call get_command_argument(1, words(1))
    call get_command_argument(2, words(2))
    call get_command_argument(3, words(3))
    call open_scene(trim(words(1)), 3_int64, scene, status, trim(words(2)))
    if (status /= 0) stop 1
    call get_band(scene, 0_int64, band, status)
    if (status /= 0) stop 2
    open (newunit=unit, file=trim(words(3)), access="stream", form="unformatted", status="replace")
    if (c_associated(band%numbers)) then
        allocate (u(band%n_photons, 3), three(band%n_photons, 3))
        n = next_numbers(band, 0_int64, u(:, 1), u(:, 2))
        if (n /= band%n_photons) stop 3
        n = next_numbers(band, 0_int64, three(:, 1), three(:, 2), three(:, 3))
        if (any(three(:, :2) /= u(:, :2))) stop 4
        u(:, 3) = three(:, 3)
        write (unit) u
    else
        allocate (v(band%n_photons, 3))
        n = next_numbers(band, 0_int64, v(:, 1), v(:, 2), v(:, 3))
        write (unit) v
    end if
    if (n /= band%n_photons) stop 5
    close (unit)
    call close_scene(scene)
end program
