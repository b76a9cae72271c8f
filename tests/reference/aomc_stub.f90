! What AOMC's main program does around its subroutine `light`: its two modules, its loops, none of its water.
!   aomc_stub LSOURCE N_BANDS TITER FILE    TITER: photons of each waveband; theta and phi go to FILE
module propagation_global
    implicit none
    real :: theta, phi
end module

module light_global
    implicit none
    integer :: lsource
    integer, allocatable, dimension(:, :, :) :: sky_nint
end module

program aomc_stub
    use propagation_global
    use light_global
    implicit none
    integer :: n_bands, titer, lam, photon, control, unit
    character(300) :: word
    call get_command_argument(1, word)
    read (word, *) lsource
    call get_command_argument(2, word)
    read (word, *) n_bands
    call get_command_argument(3, word)
    read (word, *) titer
    call get_command_argument(4, word)
    open (newunit=unit, file=trim(word), access="stream", form="unformatted", status="replace")
    allocate (sky_nint(1, 2, 0:2))
    sky_nint = titer / 2
    sky_nint(1, 2, 1:2) = titer
    control = -77 ! the program sets it for tables only
    do lam = 1, n_bands
        if (lsource == 1) control = 1
        do photon = 1, titer
            call light(1, lam, photon, control)
            write (unit) theta, phi
        end do
    end do
end program
