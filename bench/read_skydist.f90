! Reads a sky file as AOMC does, one list-directed read a line; for waiting.py.
program read_skydist
  implicit none
  character(len=4096) :: path
  integer :: n_lines, n_zenith, last_azimuth, n_wavelengths, line, wavelength, zenith, azimuth
  real :: value
  real, allocatable :: wavelengths(:), table(:, :, :)
  call get_command_argument(1, path)
  open (10, file=trim(path), status='old', action='read')
  read (10, *) n_lines, n_zenith, last_azimuth, n_wavelengths
  allocate (wavelengths(n_wavelengths), table(0:last_azimuth, n_zenith, n_wavelengths))
  table = 0.0
  read (10, *) wavelengths
  do line = 1, n_lines
    read (10, *) wavelength, zenith, azimuth, value
    table(azimuth, zenith, wavelength) = value
  end do
  print *, sum(table)
end program
