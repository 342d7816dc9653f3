function [filters, pattern] = reference_filters(id, data)
% Transmittances (31 x colours) and mosaic of a camera: ISETCam's tables `nikonD100` and `isetRGB` on a Bayer mosaic, or
% Gaussian bells exp(-((w - centre) / sigma)^2 / 2) on the mosaic that gaussian_filter_sets.json gives.
wave_nm = [400:10:700].';
pattern = [2 1; 3 2];
switch id
  case 'nikonD100', filters = ieReadColorFilter(wave_nm, 'NikonD100');
  case 'isetRGB', filters = ieReadColorFilter(wave_nm, 'RGB');
  otherwise
    sets = read_json(data, 'gaussian_filter_sets.json');
    set = sets(strcmp({sets.id}, id));
    filters = exp(-((wave_nm - set.center_nm.') ./ set.sigma_nm.') .^ 2 / 2);
    pattern = set.pattern;
end
end
