! What gfortran makes of list-directed files: lines `K path` on standard input, one line of results for each.
! K is S for skydist.inp, or the number of columns of lambbot.inp (3, 5) and difcol.inp (2).
! Plain twin of aomc_sky.formats.aomc.skydist, lambbot and difcol. Values that a READ leaves unset keep -77.
program read_list
  use iso_fortran_env, only: int64, real64, input_unit
  implicit none
  integer, parameter :: unset = -77, n_most = 100000
  character(len=1024) :: path
  integer :: status, unit, n_columns
  do
     read (input_unit, '(A)', iostat=status) path
     if (status /= 0) exit
     open (newunit=unit, file=trim(path(3:)), status='old', action='read')
     if (path(1:1) == 'S') then
        call read_sky()
     else
        read (path(1:1), '(I1)') n_columns
        call read_bands(n_columns)
     end if
     close (unit)
  end do
contains
  subroutine read_sky()
    integer :: n, nz, na, nw, i, status, place(3)
    real(real64), allocatable :: wave(:)
    integer(int64), allocatable :: rows(:, :)
    real(real64) :: number
    n = unset; nz = unset; na = unset; nw = unset
    read (unit, *, iostat=status) n, nz, na, nw
    if (status /= 0 .or. n < 0 .or. n > n_most .or. nw < 0 .or. nw > n_most) then
       print '(A)', 'error'
       return
    end if
    allocate (wave(nw), rows(4, n))
    wave = unset
    read (unit, *, iostat=status) wave
    do i = 1, n
       if (status /= 0) exit
       place = unset
       number = unset
       read (unit, *, iostat=status) place(1), place(2), place(3), number
       rows(1:3, i) = place
       rows(4, i) = transfer(number, 0_int64)
    end do
    if (status /= 0) then
       print '(A)', 'error'
    else
       print '(A,*(1X,I0))', 'ok', n, nz, na, nw, transfer(wave, [0_int64], nw), rows
    end if
  end subroutine read_sky

  subroutine read_bands(n_columns)
    integer, intent(in) :: n_columns
    integer :: n, i, status
    real(real64), allocatable :: rows(:, :)
    n = unset
    read (unit, *, iostat=status) n
    if (status /= 0 .or. n < 0 .or. n > n_most) then
       print '(A)', 'error'
       return
    end if
    allocate (rows(n_columns, n))
    rows = unset
    do i = 1, n
       read (unit, *, iostat=status) rows(:, i)
       if (status /= 0) exit
    end do
    if (status /= 0) then
       print '(A)', 'error'
    else
       print '(A,*(1X,I0))', 'ok', n, transfer(rows, [0_int64], n * n_columns)
    end if
  end subroutine read_bands
end program read_list
