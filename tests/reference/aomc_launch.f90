! What the AOMC program launches from a sky file, by its own rules in its own arithmetic (32-bit reals):
! the sky of each waveband, the weight of every patch, their sum, and the photons patch by patch.
! Reads: path, iterations, number of wavebands, their wavelengths. Prints: waveband, zenith index, azimuth index, photons.
program aomc_launch
  implicit none
  real, parameter :: pi = 3.14159265
  character(len=1000) :: path
  integer :: iterations, n_bands, n_rows, n_zenith, n_azimuth, n_sky, band, sky, row, z, a, k, photons, launched
  real :: value, theta, ring, total, running
  real, allocatable :: wavelength(:), table_wavelength(:), radiance(:, :, :), weight(:, :)

  read (*, '(a)') path
  read (*, *) iterations, n_bands
  allocate (wavelength(n_bands))
  read (*, *) wavelength
  open (10, file=trim(path), status='old', action='read')
  read (10, *) n_rows, n_zenith, n_azimuth, n_sky
  allocate (table_wavelength(n_sky), radiance(n_zenith, 0:n_azimuth, n_sky), weight(n_zenith, 0:n_azimuth))
  read (10, *) table_wavelength
  radiance = 0.0
  do row = 1, n_rows
    read (10, *) k, z, a, value
    radiance(z, a, k) = value
  end do
  close (10)

  do band = 1, n_bands
    sky = n_sky
    do k = 1, n_sky - 1
      if (wavelength(band) < (table_wavelength(k) + table_wavelength(k + 1)) / 2) then
        sky = k
        exit
      end if
    end do
    do z = 1, n_zenith
      theta = z * pi / 180.0
      ring = 0.01745329
      if (z == 1 .or. z == 89) ring = 0.0261799
      do a = 0, n_azimuth
        weight(z, a) = radiance(z, a, sky) * sin(theta) * ring * 0.01745329 * cos(theta)
      end do
    end do
    total = 0.0
    do a = 0, n_azimuth
      do z = 1, n_zenith
        total = total + weight(z, a)
      end do
    end do
    running = 0.0
    launched = 0
    do z = 1, n_zenith
      do a = 0, n_azimuth
        photons = 0
        if (total > 0.0) photons = nint(weight(z, a) / total * real(iterations))
        running = running + real(photons)
        if (nint(running) > launched) then
          print '(i0,1x,i0,1x,i0,1x,i0)', band, z, a, nint(running) - launched
          launched = nint(running)
        end if
      end do
    end do
  end do
end program aomc_launch
