function make_metrics(data, out)
% Metrics alone: colour differences, ISO 12233 on an analytic edge, S-CIELAB on an analytic pair of pictures.
color_differences(data, out);
analytic_edge(out);
analytic_pair(out);
end

function color_differences(data, out)
% The pairs are inputs: twelve chosen at random, and nine of those published with CIEDE2000 (Sharma, Wu and Dalal, 2005).
values = read_json(data, 'metric_deltaE.json');
white = values.white.';
values.lab1 = ieXYZ2LAB(values.xyz1, white);
values.lab2 = ieXYZ2LAB(values.xyz2, white);
values.dE76 = deltaEab(values.xyz1, values.xyz2, white, '1976');
values.dE94 = deltaEab(values.xyz1, values.xyz2, white, '1994');
values.dE00 = deltaEab(values.xyz1, values.xyz2, white, '2000');
values.sharma_dE00 = deltaE2000(values.sharma_lab1, values.sharma_lab2);
values.sharma_dE94 = deltaE94(values.sharma_lab1, values.sharma_lab2);
values.srgb2xyz_out = squeeze(srgb2xyz(reshape(values.srgb2xyz_in, 3, 1, 3)));
values.lrgb2srgb_out = lrgb2srgb(values.lrgb2srgb_in);
write_json(out, 'metric_deltaE.json', values);
end

function analytic_edge(out)
% A step from 0.1 to 0.9 across a line that moves one pixel in seven rows, with a Gaussian blur along the rows.
PITCH_MM = 2.8e-3; SIGMA = [0.7 0.9 1.2];
[col, row] = meshgrid(1:60, 1:80);
distance = col - (30 + (row - 40.5) / 7);
edge = zeros(80, 60, 3);
names = 'rgb';
for c = 1:3
  edge(:, :, c) = 0.1 + 0.8 * normcdf(distance / SIGMA(c));
  write_csv(out, ['metric_mtf_edge_' names(c) '.csv'], edge(:, :, c));
end
all_colors = mtf_of(edge, PITCH_MM);
green = mtf_of(edge(:, :, 2), PITCH_MM);
across = 1 / cos(atan(1 / 7));  % Frequencies perpendicular to the edge are higher by this factor than along the rows.
write_json(out, 'metric_mtf_edge.json', struct('dx_mm', PITCH_MM, 'weights', [0.3 0.6 0.1], 'sigma_px', SIGMA, ...
  'edge', 'edge column = 30+(row-40.5)/7 (1-based), value=0.1+0.8*Phi((col-edge)/sigma)', ...
  'mtf50', all_colors.mtf50, 'nyquist', all_colors.nyquist, 'alias_pct', all_colors.alias_pct, 'freq', all_colors.freq, ...
  'mtf_rgbl', all_colors.mtf, 'mono_g_mtf50', green.mtf50, 'mono_g_mtf', green.mtf, ...
  'mtf50_exact_rgbl', [all_colors.mtf50_rgb_exact all_colors.mtf50_exact], ...
  'analytic_gauss_mtf50_perp', across * sqrt(log(2) / 2) ./ (pi * SIGMA * PITCH_MM)));
end

function analytic_pair(out)
% Two pictures of 64 x 64 pixels in XYZ at 60 samples per degree.
WHITE = [95.047 100 108.883];
[x, y] = meshgrid(1:64);
level = 50 + 25 * sin(2 * pi * x / 32) .* cos(2 * pi * y / 40);
error_of = 6 * sin(2 * pi * x / 24 + y / 9) + 6 * sin(2 * pi * x / 5);
first = max(cat(3, 0.95 * level, level, 1.08 * level), 0);
second = max(cat(3, 0.95 * (level + error_of), level + 0.6 * error_of, 1.08 * (level - 1.2 * error_of)), 0);
defaults = scParams;
values = struct('defaults', struct('sampPerDeg', defaults.sampPerDeg, 'filterSize', defaults.filterSize, ...
                                   'deltaEversion', defaults.deltaEversion, 'basis', '120 dpi at 0.5 m'));
for formula = {'2000', '1976', '1994'}
  params = struct('deltaEversion', formula{1}, 'imageFormat', 'xyz10', 'sampPerDeg', 60, 'filterSize', 60, 'filters', []);
  map = scielab(first, second, WHITE, params);
  write_csv(out, ['metric_scielab_out_dE' formula{1} '.csv'], map);
  plain = deltaEab(first, second, WHITE, formula{1});
  values.(['mean_dE' formula{1}]) = mean(map(:));
  values.(['center16_mean_dE' formula{1}]) = mean(map(25:40, 25:40)(:));
  values.(['plain_mean_dE' formula{1}]) = mean(plain(:));
end
filters = scPrepareFilters(params);
middle = 30;
values.sampPerDeg = 60; values.filterSize = 60; values.white = WHITE; values.imageFormat = 'xyz10';
values.image_def = ['x,y 1-based 64x64: Y=50+25 sin(2pi x/32) cos(2pi y/40); im1=(.95Y,Y,1.08Y); ' ...
  'n=6 sin(2pi x/24+y/9)+6 sin(2pi x/5); im2=(.95(Y+n),Y+.6n,1.08(Y-1.2n)); clipped at 0; arrays are XYZ'];
values.filter_sum = cellfun(@(f) sum(f(:)), filters);
values.filter_center = cellfun(@(f) f(middle, middle), filters);
values.filter_size = cell2mat(cellfun(@size, filters(:), 'UniformOutput', false));
values.filter_row_mid = cell2mat(cellfun(@(f) f(middle, :), filters(:), 'UniformOutput', false));
write_json(out, 'metric_scielab.json', values);
end
