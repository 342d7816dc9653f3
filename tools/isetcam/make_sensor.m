function make_sensor(data, out)
% Filters, a uniform field with and without noise, and whole mosaics of the chart and of the edge in volts.
for id = {'nikonD100', 'isetRGB'}
  write_csv(out, ['filters_' id{1} '_400_10_700.csv'], reference_filters(id{1}, data));
end
sets = read_json(data, 'gaussian_filter_sets.json');  % These were chosen, not computed.
write_json(out, 'gaussian_filter_sets.json', sets);

images = struct('mac', chart_image(), 'bar', edge_image());
for target = {'mac', 'bar'}
  for id = {'nikonD100', 'isetRGB', 'g3a', 'g4a', 'g5a', 'g6a', 'g7a'}
    held = read_json(data, ['ip_case_' id{1} '.json']);
    [filters, pattern] = reference_filters(id{1}, data);
    frame = held.([target{1} '_size']);
    held_s = held.([target{1} '_exp_time_s']);
    sensor = camera(filters, pattern, frame(1), frame(2), held_s);
    found_s = autoExposure(images.(target{1}), sensor, 0.95, 'luminance');
    printf('%s of %s: exposure time %.6f s found, %.6f s held\n', target{1}, id{1}, found_s, held_s);
    if any(strcmp(id{1}, {'nikonD100', 'g6a'}))
      sensor = sensorCompute(sensor, images.(target{1}));
      write_csv(out, ['sensor_' target{1} '_volts_noisefree_' id{1} '.csv'], sensorGet(sensor, 'volts'));
    end
  end
end
uniform_field(data, out);
end

function uniform_field(data, out)
% A uniform field under D65 without fall-off, on a Bayer sensor of 146 x 146 pixels.
DARK_V_S = 1e-3; READ_V = 1e-3; GAIN_V_E = 1e-4; FRAMES = 8; EXPOSURES = 10;
scene = sceneSet(sceneSet(sceneCreate('uniform d65', 64), 'fov', 12), 'distance', 1.2);
oi = oiCompute(lens('skip'), sceneAdjustLuminance(scene, 75));
middle = round(oiGet(oi, 'size') / 2);
photons = oiGet(oi, 'photons');
illuminance = oiGet(oi, 'illuminance');
field = struct( ...
  'scene', 'uniform D65, 75 cd/m2, hfov 12 deg, cos4th off, sensor fov 6x6 deg, stats on the whole sensor', ...
  'irradiance_photons', squeeze(photons(middle(1), middle(2), :)), 'illuminance_lux', illuminance(middle(1), middle(2)), ...
  'pixel', struct('width_um', 2.8, 'fill_factor', 0.5, 'conv_gain_V_e', GAIN_V_E, 'dark_V_s', DARK_V_S, 'read_V', READ_V, ...
                  'swing_V', 1), ...
  'dv_rule', 'dv = round(volts/(swing/2^nbits)), not clipped to 2^nbits-1');
spread = struct();
for id = {'nikonD100', 'isetRGB'}
  [filters, pattern] = reference_filters(id{1}, data);
  channel = repmat(pattern, 73, 73);
  for exposure_ms = [10 40]
    exposure_s = exposure_ms * 1e-3;
    sensor = camera(filters, pattern, 146, 146, exposure_s);
    free = sensorCompute(sensor, oi);
    volts = double(sensorGet(free, 'volts'));  % Sums in single precision would err by 1e-4.
    frames = zeros(146, 146, FRAMES);
    for k = 1:FRAMES, frames(:, :, k) = sensorGet(sensorCompute(sensorSet(sensor, 'noise flag', 2), oi), 'volts'); end
    pixels_of = @(c) reshape(frames(repmat(channel == c, [1 1 FRAMES])), [], 1);
    mean_v = arrayfun(@(c) mean(volts(channel == c)), 1:3);
    expected_v = sqrt((mean_v + DARK_V_S * exposure_s) * GAIN_V_E + READ_V^2);
    pixels = arrayfun(@(c) numel(pixels_of(c)), 1:3);
    key = sprintf('%s_%dms', id{1}, exposure_ms);
    field.(key) = struct('filters', id{1}, 'exp_time_s', exposure_s, 'size_rc', [146 146], ...
      'volts_rgb_noisefree', mean_v, 'electrons_rgb_noisefree', mean_v / GAIN_V_E, ...
      'spread', std(volts(channel == 2)), ...
      'noise2_mean_volts', arrayfun(@(c) mean(pixels_of(c)), 1:3), 'noise2_std_volts', arrayfun(@(c) std(pixels_of(c)), 1:3), ...
      'noise2_std_expected', expected_v, 'nbits', 10);
    spread.(key) = struct('noise2_mean_volts', expected_v ./ sqrt(pixels), 'noise2_std_volts', expected_v ./ sqrt(2 * pixels));
    for bits = [10 12]
      digital = sensorSet(sensor, 'quantization method', sprintf('%d bit', bits));
      dv = sensorGet(sensorCompute(digital, oi), 'dv');
      field.(key).(sprintf('dv%d_rgb', bits)) = arrayfun(@(c) mean(dv(channel == c)), 1:3);
    end
  end
  times_s = arrayfun(@(k) autoExposure(oi, sensor), 1:EXPOSURES);
  field.auto_exposure.(id{1}) = struct('mean_s', mean(times_s), 'std_s', std(times_s));
  spread.auto_exposure.(id{1}) = struct('mean_s', std(times_s) / sqrt(EXPOSURES), ...
                                        'std_s', std(times_s) / sqrt(2 * (EXPOSURES - 1)));
end
write_json(out, 'sensor_uniform.json', field);
write_json(fullfile(out, 'spread'), 'sensor_uniform.json', spread);
end
