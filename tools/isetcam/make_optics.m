function make_optics(~, out)
% Optical images of the chart and of the edge, and the transfer and spread functions of the lens.
lens_of = oiGet(lens(), 'optics');
magnification = opticsGet(lens_of, 'magnification', 1.2);
fnumber = opticsGet(lens_of, 'fnumber');
chart = struct();
for falloff = {'cos4th', 'skip'; 'on', 'off'}
  oi = chart_image(falloff{1});
  key = ['cos4th_' falloff{2}];
  margin = (oiGet(oi, 'size') - [128 192]) / 2;
  write_csv(out, ['oi_macbeth_irradiance_photons_' key '.csv'], patch_values(oiGet(oi, 'photons'), margin));
  chart.(key) = struct('size_rc', oiGet(oi, 'size'), 'pad_rc', margin, ...
    'patch_illuminance_lux', patch_values(oiGet(oi, 'illuminance'), margin), ...
    'mean_illuminance_lux', oiGet(oi, 'mean illuminance'), ...
    'sample_spacing_m', oiGet(oi, 'sample spacing'), 'hfov_deg', oiGet(oi, 'fov'));
end
chart.fnumber = fnumber;
chart.focal_length_m = opticsGet(lens_of, 'focal length');
chart.magnification = magnification;
chart.image_distance_m = opticsGet(lens_of, 'image distance');
chart.focal_plane_distance_m = opticsGet(lens_of, 'focal plane distance');
chart.aperture_diam_m = opticsGet(lens_of, 'aperture diameter');
chart.transmittance = opticsGet(lens_of, 'transmittance');
chart.irradiance_formula = 'E = pi/(1+4*N^2*(1+|m|)^2) * L';
chart.irradiance_factor = pi / (1 + 4 * fnumber^2 * (1 + abs(magnification))^2);
write_json(out, 'oi_macbeth.json', chart);

wave_nm = [450 550 650];
edge = edge_image();
illuminance = oiGet(edge, 'illuminance');
planes = oiGet(edge, 'photons');
write_csv(out, 'oi_slantedbar_midrow_450_550_650.csv', squeeze(planes(320, :, (wave_nm - 390) / 10)));
write_json(out, 'oi_slantedbar.json', struct('size_rc', oiGet(edge, 'size'), 'sample_spacing_m', oiGet(edge, 'sample spacing'), ...
  'wave', wave_nm, 'mid_row_1based', 320, 'mean_illuminance', mean(illuminance(:)), 'max_illuminance', max(illuminance(:))));

% The transfer function along the frequency axis. dlMTF puts its origin at the corner; ifftshift undoes that.
frequency = 0:5:600;
[otf, ~, cutoff] = dlMTF(lens_of, cat(3, frequency, zeros(size(frequency))), wave_nm, 'mm');
for k = 1:3, otf(:, :, k) = fftshift(otf(:, :, k)); end
write_csv(out, 'optics_otf_f4_450_550_650.csv', [frequency.' squeeze(otf)]);

% The spread function on 256 x 256 points of 0.25 um.
n = 256; spacing_um = 0.25;
[fx, fy] = meshgrid((-n/2:n/2 - 1) / (n * spacing_um * 1e-3));
psf = abs(ifft2(dlMTF(lens_of, cat(3, fx, fy), wave_nm, 'mm')));
line = zeros(n, 3);
for k = 1:3, line(:, k) = fftshift(psf(:, :, k))(n/2 + 1, :); end
write_csv(out, 'optics_psf_f4_line_450_550_650.csv', [(-n/2:n/2 - 1).' * spacing_um, line]);
write_json(out, 'optics_diffraction.json', struct('wave', wave_nm, 'cutoff_cy_per_mm', cutoff, 'psf_grid_n', n, ...
  'psf_spacing_um', spacing_um, 'psf_sum', squeeze(sum(sum(psf))), 'psf_peak', max(line), ...
  'note', ['cutoff = aperture/(focalPlaneDistance*lambda); focalPlaneDistance here is the focal length, ' ...
           'so cutoff=1/(lambda*N), magnification ignored']));
end
