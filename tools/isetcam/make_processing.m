function make_processing(data, out)
% Seven cameras end to end: colour of the chart, MTF of the edge, white balance; demosaicking and the display alone.
chart = chart_image();
edge = edge_image();
jitter = struct(); jitter_spread = struct();
for id = {'nikonD100', 'isetRGB', 'g3a', 'g4a', 'g5a', 'g6a', 'g7a'}
  name = ['ip_case_' id{1} '.json'];
  held = read_json(data, name);
  [filters, pattern] = reference_filters(id{1}, data);
  n = columns(filters);
  [of_chart, chart_spread] = chart_case(id{1}, data, out, chart);
  [of_edge, edge_spread, mtf50] = edge_case(id{1}, data, out, edge);
  made = struct('id', id{1}, 'N', n, 'pattern', pattern);
  if isfield(held, 'center_nm'), made.center_nm = held.center_nm; made.sigma_nm = held.sigma_nm; end
  made.filters_31xN = filters;
  write_json(out, name, joined(made, of_chart, of_edge));
  write_json(fullfile(out, 'spread'), name, joined(chart_spread, edge_spread));
  if n > 3
    draws = numel(mtf50);
    jitter.(id{1}) = struct('mtf50_exact_each', mtf50, 'mean', mean(mtf50), 'std', std(mtf50));
    jitter_spread.(id{1}) = struct('mtf50_exact_each', repmat(std(mtf50), 1, draws), ...
                                   'mean', std(mtf50) / sqrt(draws), 'std', std(mtf50) / sqrt(2 * (draws - 1)));
  end
  printf('%s\n', id{1});
end
write_json(out, 'mtf50_multichannel_jitter.json', jitter);
write_json(fullfile(out, 'spread'), 'mtf50_multichannel_jitter.json', jitter_spread);
demosaic_alone(data, out);
display_alone(out);
end

function all = joined(varargin)
% One struct with the fields of several.
all = struct();
for part = varargin
  for key = fieldnames(part{1}).', all.(key{1}) = part{1}.(key{1}); end
end
end

function demosaic_alone(data, out)
% Random mosaics of 24 x 24 samples: mean and standard deviation of the demosaicked planes.
held = read_json(data, 'ip_demosaic_isolated.json');
made = struct(); spread = struct();
for id = fieldnames(held).'
  case_of = held.(id{1});
  n = max(case_of.pattern(:));
  sensor = camera(reference_filters(id{1}, data), case_of.pattern, 24, 24, 1);
  ip = ipSet(ipCreate, 'input', case_of.mosaic);
  draws = arrayfun(@(k) Demosaic(ip, sensor), 1:case_of.repeats, 'UniformOutput', false);
  planes_first = @(planes) permute(planes, [3 1 2]);
  each = cat(4, draws{:});
  made.(id{1}) = struct('pattern', case_of.pattern, 'mosaic', case_of.mosaic, 'repeats', case_of.repeats, ...
    'rescaled_to_max_1', n > 3, 'mean', planes_first(mean(each, 4)), 'std', planes_first(std(each, 0, 4)));
  if n > 3
    spread.(id{1}) = struct('mean', made.(id{1}).std / sqrt(case_of.repeats), ...
                            'std', made.(id{1}).std / sqrt(2 * (case_of.repeats - 1)));
  end
end
write_json(out, 'ip_demosaic_isolated.json', made);
write_json(fullfile(out, 'spread'), 'ip_demosaic_isolated.json', spread);
end

function display_alone(out)
% The display's primaries, and the colour error of perfect data: XYZ of the ideal chart on ISETCam's display, without the
% negative part, scaled to a largest value of 0.95, scored as sRGB and with the display's own model.
ip = ipCreate;
write_csv(out, 'ip_display_spd_rgb_400_10_700.csv', ipGet(ip, 'display rgb spd'));
rgb = macbethIdealColor('d65', 'xyz') * ieInternal2Display(ip);
outside = sum(any(rgb < 0, 2));
rgb = max(rgb, 0);
rgb = 0.95 * rgb / max(rgb(:));
as_srgb = color_error(RGB2XWFormat(srgb2xyz(XW2RGBFormat(lrgb2srgb(rgb), 4, 6))));
own = color_error(imageRGB2XYZ(ip, rgb));
write_json(out, 'ip_display_floor.json', struct('mean_dE1976_srgb_path', as_srgb.mean_dE1976, ...
  'mean_dE2000_srgb_path', as_srgb.mean_dE2000, 'mean_dE1976_display_path', own.mean_dE1976, ...
  'n_patches_with_negative_display_rgb', outside, ...
  'note', ['perfect XYZ through the default display model (only gamut clipping), then scored; ' ...
           'peak display value 0.95']));
end
