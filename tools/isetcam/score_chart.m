function score = score_chart(ip)
% Colour of the 24 patches and luminance noise of the six greys in a picture of the chart.
picture = ipGet(ip, 'size');
corners = [1 picture(1); picture(2) picture(1); picture(2) 1; 1 1];
[centres, delta] = macbethRectangles(corners);
lrgb = macbethSelect(ip, 0, 0, corners);
score = struct('cornerPoints_xy', corners, 'patch_centers_rc', centres, 'patch_delta', delta, 'lrgb', lrgb, ...
               'srgb', lrgb2srgb(ieClip(lrgb, 0, 1)));
% The picture is scored as if an sRGB display showed it, and with the model of the display that it was made for.
for display = {'sRGB', 'custom'}
  evalc('xyz = ipMCCXYZ(ip, corners, display{1});');  % It prints.
  score.(display{1}) = color_error(xyz);
end
% Luminance noise on 25 x 25 pixels of each grey, as in macbethLuminanceNoise, which wants a window.
[~, centres, patch] = chartRectangles(corners, 4, 6, 0.5);
grey = chartRectsData(ip, centres(:, 4:4:24), 0.6 * patch(1), true);
Y = cell2mat(cellfun(@(rgb) imageRGB2XYZ(ip, rgb)(:, 2), grey, 'UniformOutput', false));
score.lumnoise_pct = 100 * std(Y) ./ mean(Y);
score.lumnoise_meanY = mean(Y);
score.lumnoise_mean_pct = mean(score.lumnoise_pct);
score.lumnoise_nsamp = rows(Y);
end
